#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "reference/hostile_world.h"
#include "support/panda_limits.h"
#include "twin/core/random.h"
#include "twin/core/time.h"
#include "twin/reference/viability_filter.h"

namespace twin::reference {

[[nodiscard]] inline ViableAxis AxisOf(const JointLimits& limits, std::size_t joint, int lost) {
  return ViableAxis(BoundsOf(limits, joint), lost, "joint");
}

[[nodiscard]] inline ViableAxis PandaAxis(std::size_t joint, int lost) {
  return AxisOf(test::PandaLimits(), joint, lost);
}

/// The worst way upwards, cycle by cycle, without the closed form: n losses, hardest braking, and
/// again, until it no longer rises. @returns whether the upper bounds were kept all along.
[[nodiscard]] inline bool WalksBelowUpper(AxisState x, const ViableAxis& axis) {
  const AxisBounds& b = axis.kept();
  const auto within = [&] { return x.q <= b.q_max && x.dq <= b.dq_max && KeepsVelocity(x, b); };
  if (!within()) return false;
  while (x.dq > 0 || x.ddq > 0) {
    for (int i = 0; i < axis.lost(); ++i) {
      x = ViableAxis::Step(x, 0);
      if (!within()) return false;
    }
    x = ViableAxis::Step(x, std::max(-b.dddq_max, (-b.ddq_max - x.ddq) / kCycleSeconds));
    if (!within()) return false;
  }
  return true;
}

/// States of which most are near the border of the viable set.
class States {
 public:
  States(const ViableAxis& axis, std::uint64_t seed)
      : axis_(axis), random_(seed, RandomStream::kTest) {}

  AxisState Next() {
    const AxisBounds& b = axis_.kept();
    const auto uniform = [&](double low, double high) {
      return low + (high - low) * random_.Uniform(++draws_);
    };
    AxisState x{0, uniform(-b.dq_max, b.dq_max), uniform(-b.ddq_max, b.ddq_max)};
    if (uniform(0, 1) < 0.3) x.ddq = std::copysign(b.ddq_max, x.ddq);
    x.q = uniform(b.q_min, b.q_max);
    if (uniform(0, 1) > 0.75) return x;
    // To the border in q, by the walk alone, then a little to either side.
    const bool up = uniform(0, 1) < 0.5;
    double inside = up ? b.q_min : b.q_max;
    double outside = up ? b.q_max : b.q_min;
    for (int i = 0; i < 45; ++i) {
      x.q = (inside + outside) / 2;
      const bool keeps = WalksBelowUpper(up ? x : Mirrored(x, b), axis_);
      (keeps ? inside : outside) = x.q;
    }
    x.q = inside + uniform(-1e-6, 1e-6);
    return x;
  }

  /// A viable one within a millionth of the border.
  AxisState NextAtBorder() {
    for (;;) {
      const AxisState x = Next();
      const double margin = axis_.Margin(x);
      if (margin >= 0 && margin < 1e-6) return x;
    }
  }

 private:
  const ViableAxis& axis_;
  Random random_;
  std::uint64_t draws_ = 0;
};

}  // namespace twin::reference
