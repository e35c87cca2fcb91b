#include "report/approach.h"

#include <algorithm>
#include <cmath>

#include "twin/core/joint_vector.h"
#include "twin/core/time.h"

namespace twin::report {
namespace {

struct Wording {
  std::string_view what;
  std::string_view unit;
};

/// In the order of Quantity.
constexpr Wording kWordings[] = {
    {"q_d, from mid-range", "rad"},
    {"dq_d, velocity of the reference", "rad/s"},
    {"ddq_d, its acceleration", "rad/s^2"},
    {"dddq_d, its jerk", "rad/s^3"},
    {"rate of tau_J_d", "Nm/s"},
    {"q, measured, from mid-range", "rad"},
    {"dq, measured", "rad/s"},
    {"tau_J, measured", "Nm"},
    {"O_dP_EE_c, commanded speed", "m/s"},
    {"O_ddP_EE_c, its acceleration", "m/s^2"},
    {"O_dP_EE_c, commanded turning", "rad/s"},
    {"O_ddP_EE_c, its acceleration", "rad/s^2"},
    {"delbow_c, velocity of the elbow", "rad/s"},
    {"ddelbow_c, its acceleration", "rad/s^2"},
};

}  // namespace

void ApproachTracker::Add(const record::CycleRecord& cycle) {
  const RobotState& state = cycle.state;
  longest_loss_ = std::max(longest_loss_, cycle.lost_in_row);
  peak_force_ = std::max(peak_force_, HalfNorm(state.O_F_ext_hat_K, 0));
  for (const double tau : state.tau_ext_hat_filtered) {
    peak_torque_ = std::max(peak_torque_, std::abs(tau));
  }
  if (!limits_) return;
  const double time = ToSeconds(cycle.at.time_since_epoch());
  const JointLimits& joints = limits_->joints;
  AddPositions(kMeasuredPosition, state.q, time);
  AddJoints(kMeasuredVelocity, state.dq, joints.dq_max, time);
  AddJoints(kMeasuredTorque, state.tau_J, joints.tau_max, time);
  // Motions of the robot's own, such as stopping, are not commanded.
  const bool commanded = cycle.fate != record::CommandFate::kNone;
  if (commanded) {
    AddPositions(kPosition, state.q_d, time);
    AddJoints(kVelocity, state.dq_d, joints.dq_max, time);
    AddJoints(kAcceleration, state.ddq_d, joints.ddq_max, time);
    AddJoints(kJerk, cycle.dddq_d, joints.dddq_max, time);
    if (IsCartesian(state.motion_generator_mode)) AddCartesian(state, time);
  }
  const bool external = commanded && state.controller_mode == ControllerMode::kExternalController;
  if (external && last_tau_J_d_) {
    JointVector rate{};
    for (std::size_t i = 0; i < kJoints; ++i) {
      rate[i] = (state.tau_J_d[i] - (*last_tau_J_d_)[i]) / kCycleSeconds;
    }
    AddJoints(kTorqueRate, rate, joints.dtau_max, time);
  }
  last_tau_J_d_ = external ? std::optional(state.tau_J_d) : std::nullopt;
}

void ApproachTracker::AddJoints(Quantity quantity, const JointVector& values,
                                const JointVector& limits, double time) {
  for (std::size_t i = 0; i < kJoints; ++i) {
    Consider(quantity, {.axis = static_cast<int>(i),
                        .value = values[i],
                        .limit = std::copysign(limits[i], values[i]),
                        .share = std::abs(values[i]) / limits[i],
                        .time = time});
  }
}

void ApproachTracker::AddPositions(Quantity quantity, const JointVector& q, double time) {
  const JointLimits& joints = limits_->joints;
  for (std::size_t i = 0; i < kJoints; ++i) {
    const double middle = (joints.q_max[i] + joints.q_min[i]) / 2;
    const double half = (joints.q_max[i] - joints.q_min[i]) / 2;
    Consider(quantity, {.axis = static_cast<int>(i),
                        .value = q[i],
                        .limit = q[i] < middle ? joints.q_min[i] : joints.q_max[i],
                        .share = std::abs(q[i] - middle) / half,
                        .time = time});
  }
}

void ApproachTracker::AddCartesian(const RobotState& state, double time) {
  const CartesianLimits& bounds = limits_->cartesian;
  const auto consider = [&](Quantity quantity, double value, double limit) {
    Consider(quantity, {.value = value, .limit = limit, .share = value / limit, .time = time});
  };
  consider(kSpeed, HalfNorm(state.O_dP_EE_c, 0), bounds.translation.dp_max);
  consider(kSpeedup, HalfNorm(state.O_ddP_EE_c, 0), bounds.translation.ddp_max);
  consider(kTurn, HalfNorm(state.O_dP_EE_c, 3), bounds.rotation.dp_max);
  consider(kTurnup, HalfNorm(state.O_ddP_EE_c, 3), bounds.rotation.ddp_max);
  consider(kElbowVelocity, std::abs(state.delbow_c[0]), bounds.elbow.dp_max);
  consider(kElbowAcceleration, std::abs(state.ddelbow_c[0]), bounds.elbow.ddp_max);
}

void ApproachTracker::Consider(Quantity quantity, const Approach& candidate) {
  std::optional<Approach>& closest = closest_[quantity];
  if (!std::isfinite(candidate.share) || (closest && closest->share >= candidate.share)) return;
  closest = candidate;
  closest->what = kWordings[quantity].what;
  closest->unit = kWordings[quantity].unit;
}

std::vector<Approach> ApproachTracker::Closest() const {
  std::vector<Approach> all;
  for (const std::optional<Approach>& closest : closest_) {
    if (closest && closest->share > 0) all.push_back(*closest);
  }
  return all;
}

}  // namespace twin::report
