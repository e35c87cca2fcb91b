#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "twin/core/realtime.h"
#include "twin/teleop/twist_bounds.h"

namespace twin::teleop {

/// Bounds a s <= max(b, 0) of the speed s of one joint that turns alone, rad/s: an interval around
/// zero. So a bound slows a joint down and stops it, and never turns it. A measure that turning
/// hardly changes does not bind: along a boundary, rounding decides the sign of a, and the joint
/// would stick.
///
/// Threads: one. Real-time: noexcept, does not allocate, O(1).
class TurnBounds {
 public:
  static constexpr double kParallel = 1e-3;  ///< per rad, unit of the measure: 6 mm in a full turn

  /// Adds a s <= max(b, 0). Ignored if it is not finite, or |a| < kParallel.
  void Add(double a, double b, ActiveBound bound) noexcept TWIN_REALTIME {
    if (std::abs(a) < kParallel) return;
    const double most = std::max(b, 0.0) / a;  // with the sign of a
    if (a > 0 && most < high_.most) high_ = {most, bound};
    if (a < 0 && -most < low_.most) low_ = {-most, bound};
  }

  /// The closest speed to s that is allowed. @param active  the bound that s passes, none if it is
  /// allowed.
  [[nodiscard]] double Closest(double s, ActiveBound& active) const noexcept TWIN_REALTIME {
    const Side& side = s > 0 ? high_ : low_;
    active = std::abs(s) > side.most ? side.bound : ActiveBound{};
    return std::clamp(s, -low_.most, high_.most);
  }

 private:
  struct Side {
    double most = std::numeric_limits<double>::infinity();  ///< >= 0
    ActiveBound bound{};
  };
  Side low_{};
  Side high_{};
};

}  // namespace twin::teleop
