#pragma once

#include <cmath>
#include <cstdint>

#include "twin/core/random.h"
#include "twin/core/time.h"
#include "twin/reference/viable_axis.h"

namespace twin::reference {

/// Who wishes the worst of a joint, and a wire that loses as much as is allowed.
class HostileWorld {
 public:
  /// @param lost  n, that the wire may lose in a row.
  HostileWorld(int lost, std::uint64_t seed) : lost_(lost), random_(seed, RandomStream::kTest) {}

  /// A jerk, rad/s^3.
  [[nodiscard]] double Wish(const AxisState& x, const AxisBounds& b) {
    if (Draw() < 0.01) mode_ = static_cast<int>(6 * Draw());
    switch (mode_) {
      case 0: return 1e9;
      case 1: return -1e9;
      case 2: return 4 * b.dddq_max * (Draw() - 0.5);
      case 3: return x.dq > 0 ? -1e9 : 1e9;
      case 4: return x.ddq > 0 ? -b.dddq_max : b.dddq_max;
      default: return 0;
    }
  }

  /// Runs of losses, most of them as long as can be, with one command between.
  [[nodiscard]] bool Loses() {
    if (run_ > 0) {
      --run_;
      return true;
    }
    if (Draw() < 0.5) run_ = Draw() < 0.7 ? lost_ : static_cast<int>(lost_ * Draw());
    return false;
  }

 private:
  double Draw() { return random_.Uniform(++draws_); }

  int lost_;
  Random random_;
  std::uint64_t draws_ = 0;
  int mode_ = 0;
  int run_ = 0;
};

/// Whether a step may end with a velocity towards q_max: by the position at its begin.
[[nodiscard]] inline bool KeepsVelocity(const AxisState& x, const AxisBounds& b) {
  if (b.deceleration == 0 || x.dq <= 0) return true;
  const double left = b.q_max - (x.q - kCycleSeconds * x.dq);
  return left >= 0 && x.dq <= std::sqrt(2 * b.deceleration * left) - b.velocity_offset;
}

[[nodiscard]] inline AxisState Mirrored(const AxisState& x, const AxisBounds& b) {
  return {b.q_min + b.q_max - x.q, -x.dq, -x.ddq};
}

/// The bounds as a robot checks them, to a billionth of each.
[[nodiscard]] inline bool KeepsGiven(const AxisState& x, double jerk, const AxisBounds& b) {
  constexpr double kRelative = 1 + 1e-9;
  return x.q <= b.q_max + 1e-9 && x.q >= b.q_min - 1e-9 && std::abs(x.dq) <= b.dq_max * kRelative &&
         std::abs(x.ddq) <= b.ddq_max * kRelative && std::abs(jerk) <= b.dddq_max * kRelative &&
         KeepsVelocity(x, b) && KeepsVelocity(Mirrored(x, b), b);
}

}  // namespace twin::reference
