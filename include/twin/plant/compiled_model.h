#pragma once

#include <array>
#include <memory>
#include <span>
#include <vector>

#include "twin/core/joint_vector.h"
#include "twin/plant/mujoco_plant.h"

namespace twin::plant {

/// What a MuJoCo plant simulates, without any state: for those who reason about the same bodies on
/// data of their own, as a planner does. Says nothing of where anything is in a run, so it is no
/// ground truth.
///
/// Threads: the model is constant; any.
struct CompiledModel {
  std::shared_ptr<const mjModel_> model;  ///< shared: several may reason about one model
  std::array<int, kJoints> arm{};         ///< ids of the arm's joints, base to wrist
  std::vector<int> fingers;               ///< ids of the fingers' joints; empty without a hand
  double open = 0;                        ///< position of each finger of an open hand, m
};

/// Composes robot, meshes and scene and compiles them, or takes them from the cache, exactly as
/// MujocoPlant::Create() does. Of the options, those that make no body count for nothing here
/// (elasticity, load, noise, seed, perturbations).
/// @throws InputError and EnvironmentError as MujocoPlant::Create().
[[nodiscard]] CompiledModel CompileModel(const MujocoPlantOptions& options);

/// @returns generalised positions as a plant of this model has them after Reset(q): the arm at q
/// (rad), the hand open, all else where the scene puts it.
[[nodiscard]] std::vector<double> PositionsAt(const CompiledModel& compiled, const JointVector& q);

/// @returns where the arm is in generalised positions of this model, rad. @pre of the model's size.
[[nodiscard]] JointVector ArmIn(const CompiledModel& compiled, std::span<const double> qpos);

}  // namespace twin::plant
