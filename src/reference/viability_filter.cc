#include "twin/reference/viability_filter.h"

#include <algorithm>

#include <fmt/format.h>

namespace twin::reference {

AxisBounds BoundsOf(const JointLimits& limits, std::size_t joint) {
  return {.q_min = limits.q_min[joint],
          .q_max = limits.q_max[joint],
          .dq_max = limits.dq_max[joint],
          .ddq_max = limits.ddq_max[joint],
          .dddq_max = limits.dddq_max[joint],
          .velocity_offset = limits.velocity_offset[joint],
          .deceleration = limits.deceleration[joint]};
}

ViabilityFilter::ViabilityFilter(const JointLimits& limits, int lost) {
  axes_.reserve(kJoints);
  for (std::size_t i = 0; i < kJoints; ++i) {
    axes_.emplace_back(BoundsOf(limits, i), lost, fmt::format("joint {}", i + 1));
  }
}

bool ViabilityFilter::Outcome::any() const noexcept {
  return std::find(active.begin(), active.end(), true) != active.end();
}

std::optional<AxisState> ViabilityFilter::Instead(std::size_t joint, const AxisState& x,
                                                  double wish) const noexcept {
  const double jerk = axes_[joint].Nearest(x, wish);
  if (jerk == wish) return {};
  return ViableAxis::Step(x, jerk);
}

ViabilityFilter::Outcome ViabilityFilter::Next(const JointVector& q_d, const JointVector& dq_d,
                                               const JointVector& ddq_d,
                                               const JointVector& q_c) const noexcept {
  Outcome outcome{.q_c = q_c};
  for (std::size_t i = 0; i < kJoints; ++i) {
    const AxisState x{q_d[i], dq_d[i], ddq_d[i]};
    const auto instead = Instead(i, x, ViableAxis::JerkToPosition(x, q_c[i]));
    outcome.active[i] = instead.has_value();
    if (instead) outcome.q_c[i] = instead->q;
  }
  return outcome;
}

ViabilityFilter::Outcome ViabilityFilter::NextVelocity(const JointVector& q_d,
                                                       const JointVector& dq_d,
                                                       const JointVector& ddq_d,
                                                       const JointVector& dq_c) const noexcept {
  Outcome outcome{.dq_c = dq_c};
  for (std::size_t i = 0; i < kJoints; ++i) {
    const AxisState x{q_d[i], dq_d[i], ddq_d[i]};
    const auto instead = Instead(i, x, ViableAxis::JerkToVelocity(x, dq_c[i]));
    outcome.active[i] = instead.has_value();
    if (instead) outcome.dq_c[i] = instead->dq;
  }
  return outcome;
}

double ViabilityFilter::Margin(const JointVector& q_d, const JointVector& dq_d,
                               const JointVector& ddq_d) const noexcept {
  double least = axes_[0].Margin({q_d[0], dq_d[0], ddq_d[0]});
  for (std::size_t i = 1; i < kJoints; ++i) {
    least = std::min(least, axes_[i].Margin({q_d[i], dq_d[i], ddq_d[i]}));
  }
  return least;
}

}  // namespace twin::reference
