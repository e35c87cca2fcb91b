#pragma once

#include <cstdint>
#include <vector>

#include "planning/joint_space.h"
#include "planning/motion_checker.h"
#include "twin/core/joint_vector.h"

namespace twin::planning {

/// Where a path is sought.
struct SearchProblem {
  JointVector start{};
  std::vector<JointVector> goals;  ///< not empty; any of them will do
  JointBounds bounds;              ///< of what is searched
  double range = 1;                ///< length of a tree's branch, rad
  std::uint64_t seed = 0;          ///< of all that is random
};

/// A path of straight ways from the start to one of the goals, by OMPL's RRT-Connect: two trees
/// that grow from start and goals towards random configurations and towards one another.
///
/// Repeats to the bit: samples are drawn by core/random.h and nearest neighbours found by comparing
/// all, so OMPL's own random numbers, which depend on what ran before in the process, decide
/// nothing.
/// @pre start and goals are free.
/// @returns start, turning points, goal; empty when the checker's budget ran out before.
[[nodiscard]] std::vector<JointVector> FindPath(const SearchProblem& problem,
                                                MotionChecker& checker);

}  // namespace twin::planning
