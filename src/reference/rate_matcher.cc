#include "twin/reference/rate_matcher.h"

#include <algorithm>
#include <array>
#include <limits>

#include "twin/model/transform.h"

namespace twin::reference {
namespace {

using JointComponents = MovingAverage<3 * kJoints>::Values;
using PoseComponents = MovingAverage<13>::Values;

JointComponents ComponentsOf(const JointTarget& target) noexcept {
  JointComponents values;
  const auto velocities = std::copy(target.q.begin(), target.q.end(), values.begin());
  const auto accelerations = std::copy(target.dq.begin(), target.dq.end(), velocities);
  std::copy(target.ddq.begin(), target.ddq.end(), accelerations);
  return values;
}

Eigen::Quaterniond QuaternionOf(const PoseComponents& values) noexcept {
  return Eigen::Quaterniond(values.data() + 9);
}

/// @param before  quaternion whose sign is matched.
PoseComponents ComponentsOf(const PoseTarget& target, const Eigen::Quaterniond& before) noexcept {
  Eigen::Quaterniond orientation = model::Orientation(target.O_T_EE);
  if (orientation.dot(before) < 0) orientation.coeffs() *= -1;
  PoseComponents values;
  const auto twist = std::copy_n(target.O_T_EE.begin() + 12, 3, values.begin());
  const auto quaternion = std::copy(target.O_dP_EE.begin(), target.O_dP_EE.end(), twist);
  std::copy_n(orientation.coeffs().data(), 4, quaternion);
  return values;
}

}  // namespace

RateMatcher::RateMatcher(double source_rate_hz) : average_(RateMatchingWindow(source_rate_hz)) {}

void RateMatcher::Reset(const JointTarget& u0) noexcept {
  average_.Reset(ComponentsOf(u0));
}

JointTarget RateMatcher::Next(const JointTarget& u) noexcept {
  const JointComponents values = average_.Next(ComponentsOf(u));
  JointTarget y;
  std::copy_n(values.begin(), kJoints, y.q.begin());
  std::copy_n(values.begin() + kJoints, kJoints, y.dq.begin());
  std::copy_n(values.begin() + 2 * kJoints, kJoints, y.ddq.begin());
  return y;
}

TorqueRateMatcher::TorqueRateMatcher(double source_rate_hz)
    : average_(RateMatchingWindow(source_rate_hz)) {}

PoseRateMatcher::PoseRateMatcher(double source_rate_hz)
    : average_(RateMatchingWindow(source_rate_hz)) {
  Reset({});
}

void PoseRateMatcher::Reset(const PoseTarget& u0) noexcept {
  average_.Reset(ComponentsOf(u0, Eigen::Quaterniond::Identity()));
}

PoseTarget PoseRateMatcher::Next(const PoseTarget& u) noexcept {
  const PoseComponents newest = ComponentsOf(u, QuaternionOf(average_.last()));
  const PoseComponents values = average_.Next(newest);
  const Eigen::Quaterniond mean = QuaternionOf(values);
  // Rotations by a full turn within the window can cancel; then use the newest.
  constexpr double kCancelled = 1e-6;
  const bool is_newest = mean.coeffs() == QuaternionOf(newest).coeffs() || mean.norm() < kCancelled;
  PoseTarget y = u;
  if (!is_newest) {
    y.O_T_EE = model::Pose(mean.normalized(), Eigen::Vector3d::Zero());
  }
  std::copy_n(values.begin(), 3, y.O_T_EE.begin() + 12);
  std::copy_n(values.begin() + 3, 6, y.O_dP_EE.begin());
  return y;
}

}  // namespace twin::reference
