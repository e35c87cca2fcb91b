#include "twin/onboard/joint_reference.h"

#include <algorithm>
#include <cmath>

#include "twin/core/time.h"

namespace twin::onboard {

JointReference JointReference::AfterPosition(const JointVector& q_c) const noexcept {
  JointReference next;
  for (std::size_t i = 0; i < kJoints; ++i) {
    next.q_d[i] = q_c[i];
    next.dq_d[i] = (q_c[i] - q_d[i]) / kT;
    next.ddq_d[i] = (next.dq_d[i] - dq_d[i]) / kT;
    next.dddq_d[i] = (next.ddq_d[i] - ddq_d[i]) / kT;
  }
  return next;
}

JointReference JointReference::AfterVelocity(const JointVector& dq_c) const noexcept {
  JointReference next;
  for (std::size_t i = 0; i < kJoints; ++i) {
    next.dq_d[i] = dq_c[i];
    next.q_d[i] = q_d[i] + kT * dq_c[i];
    next.ddq_d[i] = (dq_c[i] - dq_d[i]) / kT;
    next.dddq_d[i] = (next.ddq_d[i] - ddq_d[i]) / kT;
  }
  return next;
}

JointReference JointReference::AfterAcceleration(const JointVector& ddq_c) const noexcept {
  JointReference next;
  for (std::size_t i = 0; i < kJoints; ++i) {
    next.ddq_d[i] = ddq_c[i];
    next.dddq_d[i] = (ddq_c[i] - ddq_d[i]) / kT;
    next.dq_d[i] = dq_d[i] + kT * ddq_c[i];
    next.q_d[i] = q_d[i] + kT * next.dq_d[i];
  }
  return next;
}

JointReference JointReference::AfterLoss() const noexcept {
  return AfterAcceleration(ddq_d);
}

bool JointReference::AtRest() const noexcept {
  const auto zero = [](double x) { return x == 0; };
  return std::all_of(dq_d.begin(), dq_d.end(), zero) &&
         std::all_of(ddq_d.begin(), ddq_d.end(), zero);
}

JointReference JointReference::Rest(const JointVector& q) noexcept {
  JointReference reference;
  reference.q_d = q;
  return reference;
}

namespace {

/// Velocity that rounding may leave at the end of a stop: below one ulp of any joint position per
/// cycle, so setting it to zero does not move the arm.
constexpr double kRestVelocity = 1e-12;

/// The x >= 0 with S(x) = sum, S(x) = (m + 1) x - d m (m + 1)/2 for m d <= x <= (m + 1) d. Above
/// x_max any value will do.
double InverseRampSum(double sum, double d, double x_max) noexcept {
  double m = 0;
  while (sum > d * (m + 1) * (m + 2) / 2 && m * d < x_max) m += 1;
  return sum / (m + 1) + d * m / 2;
}

/// Acceleration of the next cycle for one joint.
double StopAcceleration(double dq, double ddq, double a_max, double d) noexcept {
  if (std::abs(dq) <= kRestVelocity && std::abs(ddq) <= d) return 0;
  const double against = dq > 0 ? -1.0 : 1.0;
  const double x = std::min(InverseRampSum(std::abs(dq) / kT, d, a_max), a_max);
  return std::clamp(against * x, ddq - d, ddq + d);
}

}  // namespace

JointReference StopStep(const JointReference& reference, const JointLimits& limits) noexcept {
  JointVector ddq{};
  for (std::size_t i = 0; i < kJoints; ++i) {
    ddq[i] = StopAcceleration(reference.dq_d[i], reference.ddq_d[i], limits.ddq_max[i],
                              limits.dddq_max[i] * kT);
  }
  JointReference next = reference.AfterAcceleration(ddq);
  for (std::size_t i = 0; i < kJoints; ++i) {
    if (ddq[i] == 0 && std::abs(next.dq_d[i]) <= kRestVelocity) {
      next.dq_d[i] = 0;
      next.q_d[i] = reference.q_d[i];
    }
  }
  return next;
}

}  // namespace twin::onboard
