#include "twin/onboard/joint_reference.h"

#include <algorithm>

#include "twin/core/time.h"

namespace twin::onboard {
namespace {

constexpr double kT = kCycleSeconds;

}  // namespace

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

}  // namespace twin::onboard
