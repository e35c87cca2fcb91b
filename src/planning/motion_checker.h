#pragma once

#include <cstdint>

#include "twin/core/joint_vector.h"
#include "twin/planning/collision_world.h"

namespace twin::planning {

/// Asks a world about configurations and ways between them, up to a number of checks. When those
/// are used up, nothing is free any more.
///
/// Ways are checked at points so close that nothing moves by more than twice the clearance from one
/// to the next (CollisionWorld::Travel), so what is found free is free all along, not only at the
/// points. Alone, joint 1 of the Panda with its hand (1.2 m of reach) so turns by 0.017 rad from
/// point to point with a clearance of 10 mm, joint 7 by 0.07 rad.
///
/// Threads: the world's.
class MotionChecker {
 public:
  /// @param world  must outlive this. @param clearance  m, > 0.
  MotionChecker(CollisionWorld& world, double clearance, std::uint64_t most_checks)
      : world_(world), clearance_(clearance), end_(world.checks() + most_checks) {}

  [[nodiscard]] bool IsFree(const JointVector& q) { return IsFreeBy(clearance_, q); }
  /// With another clearance.
  [[nodiscard]] bool IsFreeBy(double clearance, const JointVector& q) {
    return !IsExhausted() && world_.IsFree(q, clearance);
  }

  /// Whether the straight way is free. @pre `from` is free. Far points first, so that what is not
  /// free is found soon.
  [[nodiscard]] bool IsFree(const JointVector& from, const JointVector& to);

  [[nodiscard]] bool IsExhausted() const noexcept { return world_.checks() >= end_; }
  /// Checks that are left.
  [[nodiscard]] std::uint64_t left() const noexcept {
    return IsExhausted() ? 0 : end_ - world_.checks();
  }
  [[nodiscard]] double clearance() const noexcept { return clearance_; }
  [[nodiscard]] double Travel(const JointVector& a, const JointVector& b) const noexcept {
    return world_.Travel(a, b);
  }

 private:
  CollisionWorld& world_;
  double clearance_;
  std::uint64_t end_;
};

}  // namespace twin::planning
