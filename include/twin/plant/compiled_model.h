#pragma once

#include <array>
#include <memory>
#include <span>
#include <vector>

#include "twin/core/joint_vector.h"
#include "twin/core/mobile_base.h"
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
  int base = -1;                          ///< id of a mobile base's free joint; -1: there is none
};

/// Composes robot, meshes and scene and compiles them, or takes them from the cache, exactly as
/// MujocoPlant::Create() does. Of the options, those that make no body count for nothing here
/// (elasticity, load, noise, seed, perturbations).
/// @throws InputError and EnvironmentError as MujocoPlant::Create().
[[nodiscard]] CompiledModel CompileModel(const MujocoPlantOptions& options);

/// @returns generalised positions as a plant of this model has them after Reset(q): the arm at q
/// (rad), the hand open, a mobile base at its start, all else where the scene puts it.
[[nodiscard]] std::vector<double> PositionsAt(const CompiledModel& compiled, const JointVector& q);

/// @returns where the arm is in generalised positions of this model, rad. @pre of the model's size.
[[nodiscard]] JointVector ArmIn(const CompiledModel& compiled, std::span<const double> qpos);

/// @returns where O, the arm's base, is in the world in generalised positions of this model; the
/// identity without a mobile base. @pre of the model's size.
[[nodiscard]] Transform ArmBaseIn(const CompiledModel& compiled, std::span<const double> qpos);

/// Puts a mobile base where its odometry has it, level; nothing without one.
/// @param from_start  where it is from its start. @param qpos  of PositionsAt().
void MoveBase(const CompiledModel& compiled, const BasePose& from_start, std::span<double> qpos);

}  // namespace twin::plant
