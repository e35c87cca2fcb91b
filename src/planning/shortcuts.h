#pragma once

#include <cstdint>
#include <vector>

#include "planning/motion_checker.h"
#include "twin/core/joint_vector.h"

namespace twin::planning {

/// Effort for shortening a path.
struct ShortcutEffort {
  int attempts = 150;             ///< random shortcuts to try
  std::uint64_t keep_checks = 0;  ///< checks reserved for later steps
};

/// Shortens a free path: removes turning points where the direct segment is free, then tries
/// straight segments between two random points of the path, and removes turning points again.
/// Bit-identical for the same seed; keeps the path's ends.
void Shorten(std::vector<JointVector>& path, MotionChecker& checker, std::uint64_t seed,
             const ShortcutEffort& effort);

}  // namespace twin::planning
