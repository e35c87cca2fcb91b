#pragma once

#include <cstdint>
#include <vector>

#include "planning/joint_space.h"
#include "planning/motion_checker.h"
#include "twin/core/joint_vector.h"

namespace twin::planning {

/// Definition of a path search.
struct SearchProblem {
  JointVector start{};
  std::vector<JointVector> goals;  ///< not empty; any of them suffices
  JointBounds bounds;              ///< of the search space
  double range = 1;                ///< length of a tree's branch, rad
  std::uint64_t seed = 0;          ///< of all random numbers
};

/// Finds a path of straight segments from the start to one of the goals with OMPL's RRT-Connect:
/// two trees grow from start and goals towards random configurations and towards each other.
///
/// Bit-identical on repetition: core/random.h draws the samples and a linear search finds nearest
/// neighbours. OMPL's own random numbers, which depend on the process's history, have no effect.
/// @pre start and goals are free.
/// @returns start, turning points, goal; empty if the checker's budget ran out.
[[nodiscard]] std::vector<JointVector> FindPath(const SearchProblem& problem,
                                                MotionChecker& checker);

}  // namespace twin::planning
