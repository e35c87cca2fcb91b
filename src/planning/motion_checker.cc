#include "planning/motion_checker.h"

#include <bit>
#include <cmath>

#include "planning/joint_space.h"

namespace twin::planning {

bool MotionChecker::IsFree(const JointVector& from, const JointVector& to) {
  if (!IsFree(to)) return false;
  const auto steps =
      static_cast<std::uint64_t>(std::ceil(world_.Travel(from, to) / (2 * clearance_)));
  if (steps < 2) return true;
  // Visits the middle, the quarters, the eighths and so on: each inner point once.
  for (std::uint64_t stride = std::bit_floor(steps - 1); stride > 0; stride /= 2) {
    for (std::uint64_t i = stride; i < steps; i += 2 * stride) {
      const double share = static_cast<double>(i) / static_cast<double>(steps);
      if (!IsFree(Between(from, to, share))) return false;
    }
  }
  return true;
}

}  // namespace twin::planning
