#pragma once

#include <cstdint>
#include <functional>
#include <utility>

#include "twin/core/joint_vector.h"
#include "twin/planning/collision_world.h"

namespace twin::planning {

/// Checks configurations and straight segments against a world, up to a number of checks. Once
/// these are used up, nothing counts as free.
///
/// A segment is checked at points between which nothing moves by more than twice the clearance
/// (CollisionWorld::Travel), so a free segment is free between the points too. With a clearance of
/// 10 mm, joint 1 of the Panda with hand (reach 1.2 m) moves by 0.017 rad per point, and joint 7 by
/// 0.07 rad.
///
/// Threads: the world's.
class MotionChecker {
 public:
  /// @param world  must outlive this object. @param clearance  m, > 0.
  /// @param stopped  asked at each kLookPeriod-th check; true uses up all checks. May be empty.
  MotionChecker(CollisionWorld& world, double clearance, std::uint64_t most_checks,
                std::function<bool()> stopped = {})
      : world_(world),
        clearance_(clearance),
        end_(world.checks() + most_checks),
        stopped_(std::move(stopped)) {}

  [[nodiscard]] bool IsFree(const JointVector& q) { return IsFreeBy(clearance_, q); }
  /// As IsFree() with another clearance.
  [[nodiscard]] bool IsFreeBy(double clearance, const JointVector& q) {
    if (stopped_ && world_.checks() % kLookPeriod == 0 && stopped_()) end_ = 0;
    return !IsExhausted() && world_.IsFree(q, clearance);
  }

  /// @returns true if the straight segment is free. @pre `from` is free. Tests points far apart
  /// first, to find collisions soon.
  [[nodiscard]] bool IsFree(const JointVector& from, const JointVector& to);

  [[nodiscard]] bool IsExhausted() const noexcept { return world_.checks() >= end_; }
  /// Remaining checks.
  [[nodiscard]] std::uint64_t left() const noexcept {
    return IsExhausted() ? 0 : end_ - world_.checks();
  }
  [[nodiscard]] double clearance() const noexcept { return clearance_; }
  [[nodiscard]] double Travel(const JointVector& a, const JointVector& b) const noexcept {
    return world_.Travel(a, b);
  }

 private:
  static constexpr std::uint64_t kLookPeriod = 100;

  CollisionWorld& world_;
  double clearance_;
  std::uint64_t end_;
  std::function<bool()> stopped_;
};

}  // namespace twin::planning
