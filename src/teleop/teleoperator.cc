#include "twin/teleop/teleoperator.h"

#include <algorithm>
#include <cmath>

#include "twin/core/joint_vector.h"
#include "twin/model/transform.h"

namespace twin::teleop {
namespace {

using Scalar = Eigen::Matrix<double, 1, 1>;

/// Longest period; after a later update the references wait.
constexpr double kLongestPeriod = 0.02;  // s
/// A base slower than this is at rest, m/s and rad/s.
constexpr double kStands = 0.02;
/// How long the peaks after a mode switch count as the switch's.
constexpr Duration kSwitch = std::chrono::milliseconds(500);

/// True if little is left of the translation or of the rotation.
bool RemovedMost(const Vector6& wished, const Vector6& allowed, const Vector6& scale) {
  constexpr double kWorthIt = 0.02;
  const auto took = [&](std::size_t first) {
    const double wish = HalfNorm(wished, first);
    return wish > kWorthIt * scale[first] && HalfNorm(allowed, first) < wish / 2;
  };
  return took(0) || took(3);
}

/// Each half of a twist within its speed.
Vector6 Limited(Vector6 twist, const Vector6& scale) {
  for (const std::size_t first : {0U, 3U}) {
    const double share = std::min(1.0, scale[first] / HalfNorm(twist, first));
    for (std::size_t i = first; i < first + 3; ++i) twist[i] *= share;
  }
  return twist;
}

/// @returns the configuration with the end effector's speeds lowered to the lab's caps.
TeleoperatorConfig Valid(TeleoperatorConfig config, const model::LabLimits& lab) {
  config.Validate();
  const auto lower = [](double& speed, std::optional<double> cap) {
    if (cap) speed = std::min(speed, MotionGuard::kCapShare * *cap);
  };
  lower(config.along.speed, lab.v_max);
  lower(config.about.speed, lab.w_max);
  return config;
}

Mapping::Speeds SpeedsOf(const TeleoperatorConfig& config) {
  return {.along = config.along.speed,
          .about = config.about.speed,
          .ahead = config.ahead.speed,
          .turning = config.turning.speed,
          .joint = config.joint.speed};
}

}  // namespace

Teleoperator::Teleoperator(const Parts& parts, const TeleoperatorConfig& config,
                           const WireConfig& wire, std::uint64_t seed)
    : device_(parts.device),
      base_(parts.base),
      config_(Valid(config, parts.lab)),
      port_(config.feedback),
      to_robot_(wire.to_robot, seed, kToRobotStreams),
      from_robot_(wire.from_robot, seed, kFromRobotStreams),
      mapping_(config.mapping, SpeedsOf(config_)),
      posture_(parts.arm, parts.limits),
      guard_(parts.arm, parts.limits, parts.with_hand,
             config.workspace.touch ? nullptr : parts.surroundings, parts.lab),
      bounds_(config_.along.speed, config_.about.speed),
      pose_(config_.along, config_.about, config_.workspace),
      turned_(config.joint),
      ahead_(config.ahead),
      turning_(config.turning),
      reflected_(config.feedback) {
  came_.holding = true;
}

void Teleoperator::Begin(const Transform& O_T_EE, Time now) {
  mapping_.Begin(base_ != nullptr);
  pose_.Begin(O_T_EE);
  has_posture_ = false;
  turned_.Rest();
  ahead_.Rest();
  turning_.Rest();
  reflected_.Reset();
  watch_.Begin(O_T_EE);
  last_ = now;
  last_arrival_.reset();
  switched_.reset();
  gripper_presses_.store(0, std::memory_order_relaxed);
  finished_.store(false, std::memory_order_relaxed);
}

reference::PoseTarget Teleoperator::Next(const RobotState& state, Time now) noexcept {
  if (!has_posture_) posture_.Begin(state.q);
  has_posture_ = true;
  const double T = std::min(ToSeconds(now - last_), kLongestPeriod);
  if (!(T > 0)) return pose_.target();
  last_ = now;
  TendOperator(now, T);
  connected_ = Receive(now);
  const Wish wish =
      mapping_.Update(sample_, {.connected = connected_,
                                .arm_rests = pose_.nearly_rests() && turned_.nearly_rests(),
                                .base_rests = base_rests(),
                                .O_T_EE_d = pose_.target().O_T_EE});
  if (mapping_.is_switching()) switched_ = now;
  LeadArm(wish, state, T);
  LeadBase(wish, T);
  watch_.Look(pose_.target(), {ahead_.v()[0], turning_.v()[0]}, T,
              switched_ && now - *switched_ <= kSwitch, is_stopped_);
  Answer(state, now, T);
  gripper_presses_.store(mapping_.gripper_presses(), std::memory_order_relaxed);
  finished_.store(mapping_.ends() && pose_.rests() && turned_.rests() && base_rests(),
                  std::memory_order_relaxed);
  Show(state, now);
  return pose_.target();
}

void Teleoperator::TendOperator(Time now, double T) noexcept {
  if (const auto sample = device_.Read(now)) {
    if (sample->kind != handle_.kind) port_.Recentre(HandleOf(*sample));
    handle_ = *sample;
    to_robot_.Send(now, *sample);
  }
  if (const auto came = from_robot_.Take(now)) {
    came_ = *came;
    last_answer_ = now;
  }
  felt_ = came_;
  const bool hears = last_answer_ && now - *last_answer_ <= config_.stale_after;
  felt_.holding = came_.holding || !hears;
  const bool is_held = hears && handle_.engaged;
  felt_.wrench = port_.Next(HandleOf(handle_), is_held ? came_.wrench : Vector6{}, T);
  device_.Feel(felt_);
}

bool Teleoperator::Receive(Time now) noexcept {
  if (const auto sample = to_robot_.Take(now)) {
    if (last_arrival_) {
      status_.longest_silence = std::max(status_.longest_silence, now - *last_arrival_);
    }
    ++status_.samples_arrived;
    sample_ = *sample;
    last_arrival_ = now;
  }
  return last_arrival_ && now - *last_arrival_ <= config_.stale_after && !device_.lost();
}

void Teleoperator::LeadArm(const Wish& wish, const RobotState& state, double T) noexcept {
  if (wish.joint != 0) return TurnJoint(wish, state, T);
  turned_.Rest();  // nearly at rest, or the hand would not be led
  const Vector6 wished =
      Limited(wish.pose ? pose_.TwistTowards(*wish.pose, T) : wish.twist, bounds_.scale());
  const Vector6 lead = model::WayTo(state.O_T_EE, pose_.target().O_T_EE);
  bounds_.Clear();
  pose_.AddTo(bounds_, lead, T);
  guard_.AddTo(bounds_, posture_.now(), pose_.target().O_dP_EE, state, Odometry());
  const AllowedTwist allowed = bounds_.Closest(wished);
  limit_ = RemovedMost(wished, allowed.u, bounds_.scale()) ? allowed.strongest : ActiveBound{};
  posture_.Follow(pose_.Next(allowed.u, T), state.F_T_EE, T, allowed.meets_all);
}

void Teleoperator::TurnJoint(const Wish& wish, const RobotState& state, double T) noexcept {
  const std::size_t joint = wish.joint - 1U;
  const Vector6 per_turn = posture_.PerTurn(joint, state.F_T_EE);
  // Not faster than the hand may move.
  double wished = wish.turn;
  for (const std::size_t first : {0U, 3U}) {
    const double most = bounds_.scale()[first] / HalfNorm(per_turn, first);
    wished = std::clamp(wished, -most, most);
  }
  bounds_.Clear();
  pose_.AddTo(bounds_, model::WayTo(state.O_T_EE, pose_.target().O_T_EE), T);
  TurnBounds turn_bounds;
  bounds_.AddTo(turn_bounds, per_turn);
  guard_.AddTo(turn_bounds, joint, posture_.now(), state, Odometry());
  ActiveBound strongest;
  const double allowed = turn_bounds.Closest(wished, strongest);
  limit_ = std::abs(allowed) < std::abs(wished) / 2 ? strongest : ActiveBound{};
  const double speed = turned_.Next(Scalar(allowed), T)[0];
  pose_.Follow(posture_.Turn(joint, speed, pose_.target().O_T_EE, state.F_T_EE, T), T);
}

void Teleoperator::LeadBase(const Wish& wish, double T) noexcept {
  if (base_ == nullptr) return;
  if (mapping_.stopped() != is_stopped_) {
    is_stopped_ = mapping_.stopped();
    is_stopped_ ? base_->EmergencyStop() : base_->Release();
  }
  is_braking_ = is_stopped_ || (is_braking_ && !base_rests());
  if (is_stopped_) {
    ahead_.Rest();
    turning_.Rest();
    return;
  }
  const double v = ahead_.Next(Scalar(wish.base.v), T)[0];
  const double w = turning_.Next(Scalar(wish.base.w), T)[0];
  const bool is_led = mapping_.mode() == Mode::kBase || !ahead_.rests() || !turning_.rests();
  if (is_led) base_->Drive({v, w});
}

bool Teleoperator::base_rests() const noexcept {
  if (base_ == nullptr) return true;
  const BaseTwist twist = base_->ReadState().twist;
  return ahead_.nearly_rests() && turning_.nearly_rests() && std::abs(twist.v) < kStands &&
         std::abs(twist.w) < kStands;
}

void Teleoperator::Answer(const RobotState& state, Time now, double T) noexcept {
  const bool is_felt = connected_ && mapping_.mode() == Mode::kArm && mapping_.joint() == 0 &&
                       !mapping_.is_switching();
  from_robot_.Send(now, {.sequence = ++answers_,
                         .echo = sample_.sequence,
                         .wrench = reflected_.Next(state, mapping_.in_tool_frame(), is_felt, T),
                         .mode = mapping_.mode(),
                         .stopped = mapping_.stopped(),
                         .holding = !connected_,
                         .awaits_release = mapping_.awaits_release(),
                         .hand_closed = mapping_.gripper_presses() % 2 == 1,
                         .fine = mapping_.fine(),
                         .joint = mapping_.joint(),
                         .at_border = limit_.bound != Bound::kNone,
                         .limit = limit_});
}

void Teleoperator::Show(const RobotState& state, Time now) noexcept {
  const Eigen::Vector3d error =
      model::Position(pose_.target().O_T_EE) - model::Position(state.O_T_EE);
  status_.now = now;
  status_.mode = mapping_.mode();
  status_.is_switching = mapping_.is_switching();
  status_.stopped = mapping_.stopped();
  status_.holding = !connected_;
  status_.fine = mapping_.fine();
  status_.joint = mapping_.joint();
  status_.limit = limit_;
  status_.finished = finished();
  status_.gripper_presses = mapping_.gripper_presses();
  status_.target = pose_.target();
  status_.arm_error = error.norm();
  if (mapping_.mode() == Mode::kBase && !is_braking_) {
    status_.most_drive_error = std::max(status_.most_drive_error, status_.arm_error);
  }
  status_.base_twist = {ahead_.v()[0], turning_.v()[0]};
  status_.felt = felt_.wrench;
  status_.energy = port_.energy();
  status_.least_energy = port_.least_energy();
  status_.peaks = watch_.all();
  status_.peaks_at_switch = watch_.at_switch();
  status_.samples_sent = to_robot_.sent();
  status_shown_.Publish(status_);
}

Vector6 Teleoperator::HandleOf(const OperatorSample& sample) const noexcept {
  Vector6 handle = sample.axes;
  if (sample.kind == AxisKind::kPose) return handle;
  for (std::size_t i = 0; i < handle.size(); ++i) {
    handle[i] *= i < 3 ? config_.feedback.stick_way : config_.feedback.stick_turn;
  }
  return handle;
}

}  // namespace twin::teleop
