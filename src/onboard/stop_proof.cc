#include "twin/onboard/stop_proof.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "onboard/bounds.h"
#include "twin/core/rest.h"
#include "twin/model/arm_model.h"

namespace twin::onboard {
namespace {

using internal::BrokenBound;
using internal::IsWithin;

/// Largest distance of a limited part's centre from each joint's axis, m, from the lengths of the
/// links: shoulder to elbow, elbow to wrist, wrist to flange. A part's radius does not change how
/// far it moves.
JointVector ReachOf(const model::LimitedArm& arm) noexcept {
  constexpr double kHandFront = 0.11;  // of model::HandSpheres(), from the flange
  constexpr double kHandSide = 0.066;
  const Transform& X = arm.F_T_EE;
  const double tool = std::max(std::hypot(X[12], X[13], X[14]), kHandFront);
  const double beside = std::max(std::hypot(X[12], X[13]), kHandSide);
  const double upper = std::hypot(0.316, 0.0825);
  const double lower = std::hypot(0.384, 0.0825);
  const double wrist = std::hypot(0.088, 0.107) + tool;
  const double from_shoulder = upper + lower + wrist;
  return {from_shoulder, from_shoulder, 0.0825 + lower + wrist, lower + wrist, wrist,
          wrist,         beside};
}

/// Bound of the way that every limited part takes between two positions, m.
double WayOf(const JointVector& from, const JointVector& to, const JointVector& reach) noexcept {
  double way = 0;
  for (std::size_t i = 0; i < kJoints; ++i) way += reach[i] * std::abs(to[i] - from[i]);
  return way;
}

BrokenLimit BreachOf(const model::RegionMargin& margin) noexcept {
  return {LimitKind::kRegion, static_cast<std::int8_t>(margin.region), margin.value(), margin.bound,
          margin};
}

/// A magnitude above its bound at a joint (or none); both get the sign of the value.
BrokenLimit Above(LimitKind kind, std::size_t joint, double value, double bound) noexcept {
  return {kind, static_cast<std::int8_t>(joint), value, std::copysign(bound, value), {}};
}

constexpr std::size_t kNoJoint = static_cast<std::size_t>(-1);

}  // namespace

std::string Describe(const model::LabLimits& limits, const BrokenLimit& breach) {
  const auto joint = [&](std::string_view limit, std::string_view does, std::string_view unit) {
    return fmt::format("limit {}: joint {} {} {:.6g} {}; the bound is {:.6g} {}", limit,
                       breach.axis + 1, does, breach.value, unit, breach.bound, unit);
  };
  const auto hand = [&](std::string_view limit, std::string_view does, std::string_view unit) {
    return fmt::format("limit {}: the end effector {} {:.6g} {}; the bound is {:.6g} {}", limit,
                       does, breach.value, unit, breach.bound, unit);
  };
  switch (breach.kind) {
    case LimitKind::kRegion:
      return fmt::format("{}; the stop would pass it by {:.3g} mm",
                         model::Describe(limits, breach.region), -breach.region.margin * 1e3);
    case LimitKind::kJointRange: return joint("of the joint's range", "reaches", "rad");
    case LimitKind::kJointSpeed: return joint("speed.joints", "moves at", "rad/s");
    case LimitKind::kSpeed: return hand("speed.end_effector", "moves at", "m/s");
    case LimitKind::kTurn: return hand("speed.rotation", "turns at", "rad/s");
    case LimitKind::kForce: return hand("force", "is pushed with", "N");
    case LimitKind::kTorque: return joint("torque", "is turned with", "Nm");
    case LimitKind::kNoStop:
      return joint(fmt::format("of {} cycles for a stop", StopProof::kMostCycles), "still moves at",
                   "rad/s");
  }
  return {};
}

std::optional<BrokenLimit> CheckForces(const model::LabLimits& limits, const Vector6& O_F_ext_hat_K,
                                       const JointVector& tau_ext) noexcept {
  const double force = HalfNorm(O_F_ext_hat_K, 0);
  if (limits.force_max && !IsWithin(force, *limits.force_max)) {
    return Above(LimitKind::kForce, kNoJoint, force, *limits.force_max);
  }
  for (std::size_t i = 0; limits.tau_max && i < kJoints; ++i) {
    if (IsWithin(std::abs(tau_ext[i]), (*limits.tau_max)[i])) continue;
    return Above(LimitKind::kTorque, i, tau_ext[i], (*limits.tau_max)[i]);
  }
  return {};
}

StopProof::StopProof(const JointLimits& joints, model::LabLimits limits,
                     const model::LimitedArm& arm)
    : joints_(joints), limits_(std::move(limits)), arm_(arm), reach_(ReachOf(arm)) {}

void StopProof::SetEndEffector(const Transform& F_T_EE) noexcept {
  arm_.F_T_EE = F_T_EE;
  reach_ = ReachOf(arm_);
}

std::optional<BrokenLimit> StopProof::Check(JointReference from) const noexcept {
  Gap gap = GapAt(from.q_d);
  if (!(gap.nearest.margin >= 0)) return BreachOf(gap.nearest);
  for (int cycle = 0; cycle < kMostCycles; ++cycle) {
    if (const auto breach = CheckJoints(from)) return breach;
    if (const auto breach = CheckTwist(from)) return breach;
    if (from.AtRest()) return {};
    const JointReference next = StopStep(from, joints_);
    if (const auto breach = Advance(gap, from.q_d, next.q_d)) return breach;
    from = next;
  }
  const std::size_t joint = FastestJoint(from.dq_d);
  return Above(LimitKind::kNoStop, joint, from.dq_d[joint], 0);
}

StopProof::Gap StopProof::GapAt(const JointVector& q) const noexcept {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  const auto least = model::LeastMargin(limits_, arm_, q);
  return {.nearest = least ? *least : model::RegionMargin{.margin = kFar}};
}

std::optional<BrokenLimit> StopProof::Advance(Gap& gap, const JointVector& from,
                                              const JointVector& to) const noexcept {
  const double way = WayOf(from, to, reach_);
  if (!gap.is_exact && gap.nearest.margin < way) gap = GapAt(from);
  if (gap.nearest.margin >= way) {  // nothing on the way is outside
    gap.nearest.margin -= way;
    gap.is_exact = gap.is_exact && way == 0;
    return {};
  }
  const Gap after = GapAt(to);
  const double between = (gap.nearest.margin + after.nearest.margin - way) / 2;
  if (!(after.nearest.margin >= 0 && between >= 0)) {
    model::RegionMargin broken = after.nearest;
    broken.margin = std::min(broken.margin, between);
    return BreachOf(broken);
  }
  gap = after;
  return {};
}

std::optional<BrokenLimit> StopProof::CheckJoints(const JointReference& reference) const noexcept {
  for (std::size_t i = 0; i < kJoints; ++i) {
    const double dq = reference.dq_d[i];
    if (limits_.dq_max && !IsWithin(std::abs(dq), (*limits_.dq_max)[i])) {
      return Above(LimitKind::kJointSpeed, i, dq, (*limits_.dq_max)[i]);
    }
    const auto end = BrokenBound(reference.q_d[i], joints_.q_min[i], joints_.q_max[i]);
    if (!end) continue;
    return BrokenLimit{
        LimitKind::kJointRange, static_cast<std::int8_t>(i), reference.q_d[i], *end, {}};
  }
  return {};
}

std::optional<BrokenLimit> StopProof::CheckTwist(const JointReference& reference) const noexcept {
  constexpr double kAny = std::numeric_limits<double>::infinity();
  const double v_max = limits_.v_max.value_or(kAny);
  const double w_max = limits_.w_max.value_or(kAny);
  double v = 0;  // bounds of the twist's norms
  double w = 0;
  for (std::size_t i = 0; i < kJoints; ++i) {
    v += reach_[i] * std::abs(reference.dq_d[i]);
    w += std::abs(reference.dq_d[i]);
  }
  if (v <= v_max && w <= w_max) return {};
  const Vector6 twist = model::ArmModel::Panda().Twist(model::Frame::kEndEffector, reference.q_d,
                                                       reference.dq_d, arm_.F_T_EE);
  v = HalfNorm(twist, 0);
  w = HalfNorm(twist, 3);
  if (!IsWithin(v, v_max)) return Above(LimitKind::kSpeed, kNoJoint, v, v_max);
  if (!IsWithin(w, w_max)) return Above(LimitKind::kTurn, kNoJoint, w, w_max);
  return {};
}

}  // namespace twin::onboard
