#pragma once

#include <array>
#include <memory>
#include <span>
#include <vector>

#include "twin/core/joint_vector.h"
#include "twin/core/mobile_base.h"
#include "twin/plant/mujoco_plant.h"

namespace twin::plant {

/// The model of a MuJoCo plant without state, for code that computes on its own data, such as a
/// planner. It contains no positions of a run, so it is not ground truth.
///
/// Threads: the model is constant; any.
struct CompiledModel {
  std::shared_ptr<const mjModel_> model;  ///< shared by its users
  std::array<int, kJoints> arm{};         ///< ids of the arm's joints, base to wrist
  std::vector<int> fingers;               ///< ids of the fingers' joints; empty without a hand
  double open = 0;                        ///< position of each finger of an open hand, m
  int base = -1;                          ///< id of a mobile base's free joint, or -1
};

/// Composes robot, meshes and scene and compiles them, or loads them from the cache, like
/// MujocoPlant::Create(). Options that do not affect bodies are ignored (elasticity, load, noise,
/// seed, perturbations, friction law, delay).
/// @throws InputError and EnvironmentError as MujocoPlant::Create().
[[nodiscard]] CompiledModel CompileModel(const MujocoPlantOptions& options);
/// The arms of a model of several (SharedModel), each with its own joints in the one model.
/// @param arms  as SharedModel::Create's, or one alone.
[[nodiscard]] std::vector<CompiledModel> CompileModels(std::span<const MujocoPlantOptions> arms);

/// @returns generalised positions after a plant's Reset(q): the arm at q (rad), the hand open, a
/// mobile base at its start, everything else as in the scene.
[[nodiscard]] std::vector<double> PositionsAt(const CompiledModel& compiled, const JointVector& q);

/// @returns the arm's joint positions in `qpos`, rad. @pre qpos has the model's size.
[[nodiscard]] JointVector ArmIn(const CompiledModel& compiled, std::span<const double> qpos);

/// @returns the pose in the world of O, the arm's base, for `qpos`; MujocoPlantOptions::pose
/// without a mobile base. @pre qpos has the model's size.
[[nodiscard]] Transform ArmBaseIn(const CompiledModel& compiled, std::span<const double> qpos);

/// Moves a mobile base to a pose of its odometry, level; no effect without a base.
/// @param from_start  pose relative to its start. @param qpos  from PositionsAt().
void MoveBase(const CompiledModel& compiled, const BasePose& from_start, std::span<double> qpos);

}  // namespace twin::plant
