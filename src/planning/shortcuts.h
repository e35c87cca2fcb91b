#pragma once

#include <cstdint>
#include <vector>

#include "planning/motion_checker.h"
#include "twin/core/joint_vector.h"

namespace twin::planning {

/// How much work may go into a shorter path.
struct ShortcutEffort {
  int attempts = 150;             ///< random shortcuts that are tried
  std::uint64_t keep_checks = 0;  ///< of the budget, for what comes after
};

/// Shortens a free path: takes turning points out where the straight way past them is free, then
/// tries straight ways between two random places of the path, and takes out once more. Repeats to
/// the bit with the same seed; ends of the path stay.
void Shorten(std::vector<JointVector>& path, MotionChecker& checker, std::uint64_t seed,
             const ShortcutEffort& effort);

}  // namespace twin::planning
