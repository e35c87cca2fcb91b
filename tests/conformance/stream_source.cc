#include "conformance/stream_source.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "conformance/pose_math.h"
#include "twin/core/time.h"

namespace twin::test {
namespace {

template <std::size_t N>
double Length(const std::array<double, N>& v) {
  double sum = 0;
  for (const double x : v) sum += x * x;
  return std::sqrt(sum);
}

/// What a client must send so that after the robot's low-pass `value` comes out.
double Unfiltered(double value, double last, double cutoff_hz) {
  if (cutoff_hz >= 1000) return value;
  const double gain = kT / (kT + 1 / (2 * M_PI * cutoff_hz));
  return last + (value - last) / gain;
}

template <std::size_t N>
std::array<double, N> Unfiltered(std::array<double, N> value, const std::array<double, N>& last,
                                 double cutoff_hz) {
  for (std::size_t i = 0; i < N; ++i) value[i] = Unfiltered(value[i], last[i], cutoff_hz);
  return value;
}

}  // namespace

template <std::size_t N>
std::array<double, N> Tracker::Next(const std::array<double, N>& v, const std::array<double, N>& a,
                                    const std::array<double, N>& v_target) const {
  std::array<double, N> gap{};
  for (std::size_t i = 0; i < N; ++i) gap[i] = v_target[i] - v[i];
  const double length = Length(gap);
  // Near the target exponentially, far from it so that the acceleration can still be taken off.
  const double wish = std::min({length / (6 * kT), std::sqrt(1.2 * j_max * length), a_max});
  std::array<double, N> change{};
  for (std::size_t i = 0; i < N; ++i) change[i] = (length > 0 ? gap[i] / length * wish : 0) - a[i];
  const double step = Length(change);
  const double scale = step > j_max * kT ? j_max * kT / step : 1;
  std::array<double, N> next{};
  for (std::size_t i = 0; i < N; ++i) next[i] = a[i] + scale * change[i];
  return next;
}

StreamSource::StreamSource(const StreamPlan& plan, const RobotState& start)
    : modes_(plan.modes),
      with_elbow_(plan.with_elbow),
      vigour_(plan.vigour),
      joints_(plan.robot.onboard.limits),
      cartesian_(plan.robot.onboard.cartesian),
      filters_(plan.robot.onboard.filters),
      dice_(plan.seed ^ 0x5eed),
      home_(start.O_T_EE_c),
      elbow_home_(start.elbow_c[0]) {}

void StreamSource::SetEdge(const Disturbance& disturbance) {
  has_edge_ = true;
  edge_ = disturbance;
  // Only a motion that keeps its direction comes close to a limit of velocity or position.
  const bool keeps = edge_.edge == Edge::kVelocity || edge_.edge == Edge::kPosition;
  if (keeps) cycles_to_draw_ = std::numeric_limits<int>::max();
}

void StreamSource::DrawTargets() {
  cycles_to_draw_ = dice_.Whole(30, 200);
  for (double& x : dq_target_) x = dice_.Between(-1, 1);
  for (double& x : twist_target_) x = dice_.Between(-0.6, 0.6);
  elbow_target_ = dice_.Between(-1, 1);
  for (double& x : tau_rate_) x = dice_.Between(-1, 1);
}

JointVector StreamSource::JointAcceleration(const RobotState& state, bool settles) {
  JointVector acceleration{};
  for (std::size_t i = 0; i < kJoints; ++i) {
    const bool edge = has_edge_ && edge_.axis == i && !settles;
    const double q = state.q_d[i];
    double target = settles ? 0 : vigour_ * joints_.dq_max[i] * dq_target_[i];
    target =
        std::clamp(target, 4 * (joints_.q_min[i] + 0.02 - q), 4 * (joints_.q_max[i] - 0.02 - q));
    Tracker tracker{vigour_ * joints_.ddq_max[i], std::min(vigour_, 0.9) * joints_.dddq_max[i]};
    if (edge) tracker = {0.6 * joints_.ddq_max[i], 0.6 * joints_.dddq_max[i]};
    if (edge && edge_.edge == Edge::kJerk) tracker.j_max = edge_.size * joints_.dddq_max[i];
    if (edge && edge_.edge == Edge::kAcceleration) tracker.a_max = edge_.size * joints_.ddq_max[i];
    if (edge && edge_.edge != Edge::kPosition) {
      target = std::copysign(
          edge_.edge == Edge::kVelocity ? edge_.size * joints_.dq_max[i] : joints_.dq_max[i],
          target);
    }
    if (edge && edge_.edge == Edge::kPosition) {
      const double limit = dq_target_[i] > 0 ? joints_.q_max[i] : joints_.q_min[i];
      const double speed = 0.9 * joints_.dq_max[i];
      target = std::clamp(20 * (limit * edge_.size - q), -speed, speed);
    }
    acceleration[i] = tracker.Next<1>({state.dq_d[i]}, {state.ddq_d[i]}, {target})[0];
  }
  return acceleration;
}

Vector6 StreamSource::CartesianAcceleration(const RobotState& state, bool settles) {
  const Vector3 back = RotationBetween(state.O_T_EE_c, home_);
  Vector6 acceleration{};
  for (std::size_t block = 0; block < 2; ++block) {
    const CartesianBound& bound = block == 0 ? cartesian_.translation : cartesian_.rotation;
    const bool edge = has_edge_ && edge_.axis == block && !settles;
    Vector3 target{};
    Vector3 v{};
    Vector3 a{};
    for (std::size_t i = 0; i < 3; ++i) {
      const double away = block == 0 ? home_[12 + i] - state.O_T_EE_c[12 + i] : back[i];
      const double pull = edge && edge_.edge == Edge::kVelocity ? 0 : 3;
      target[i] = settles ? 0 : vigour_ * bound.dp_max * twist_target_[3 * block + i] + pull * away;
      v[i] = state.O_dP_EE_c[3 * block + i];
      a[i] = state.O_ddP_EE_c[3 * block + i];
    }
    const double fast = edge ? bound.dp_max : vigour_ * bound.dp_max;
    const double length = std::max(Length(target), 1e-9);
    const double most = edge && edge_.edge == Edge::kVelocity ? edge_.size * fast : fast;
    if (length > most || edge) {
      for (double& x : target) x *= most / length;
    }
    Tracker tracker{vigour_ * bound.ddp_max, 0.5 * vigour_ * bound.dddp_max};
    if (edge) tracker = {0.1 * bound.ddp_max, 0.1 * bound.dddp_max};
    if (edge && edge_.edge == Edge::kJerk) tracker.j_max = edge_.size * bound.dddp_max;
    if (edge && edge_.edge == Edge::kAcceleration) tracker.a_max = edge_.size * bound.ddp_max;
    const Vector3 next = tracker.Next<3>(v, a, target);
    std::copy(next.begin(), next.end(),
              acceleration.begin() + static_cast<std::ptrdiff_t>(3 * block));
  }
  return acceleration;
}

double StreamSource::ElbowAcceleration(const RobotState& state, bool settles) {
  const CartesianBound& bound = cartesian_.elbow;
  const bool edge = has_edge_ && edge_.axis == 2 && !settles;
  double target =
      settles ? 0 : vigour_ * bound.dp_max * elbow_target_ + 2 * (elbow_home_ - state.elbow_c[0]);
  Tracker tracker{vigour_ * bound.ddp_max, std::min(vigour_, 0.9) * bound.dddp_max};
  if (edge) {
    tracker = {0.3 * bound.ddp_max, 0.3 * bound.dddp_max};
    if (edge_.edge == Edge::kJerk) tracker.j_max = edge_.size * bound.dddp_max;
    if (edge_.edge == Edge::kAcceleration) tracker.a_max = edge_.size * bound.ddp_max;
    const double limit = target > 0 ? joints_.q_max[2] : joints_.q_min[2];
    target =
        edge_.edge == Edge::kPosition
            ? std::clamp(20 * (limit * edge_.size - state.elbow_c[0]), -2.0, 2.0)
            : std::copysign(
                  edge_.edge == Edge::kVelocity ? edge_.size * bound.dp_max : bound.dp_max, target);
  }
  return tracker.Next<1>({state.delbow_c[0]}, {state.ddelbow_c[0]}, {target})[0];
}

void StreamSource::FillJoints(const RobotState& state, bool settles, RobotCommand& command) {
  const JointVector acceleration = JointAcceleration(state, settles);
  for (std::size_t i = 0; i < kJoints; ++i) {
    const double dq = state.dq_d[i] + kT * acceleration[i];
    command.dq_c[i] = Unfiltered(dq, state.dq_d[i], filters_.joint_velocity_hz);
    command.q_c[i] = Unfiltered(state.q_d[i] + kT * dq, state.q_d[i], filters_.joint_position_hz);
  }
  // What the motion generator does not use stays zero.
  if (modes_.generator == MotionGeneratorMode::kJointPosition) command.dq_c = JointVector{};
  if (modes_.generator == MotionGeneratorMode::kJointVelocity) command.q_c = JointVector{};
}

void StreamSource::FillCartesian(const RobotState& state, bool settles, RobotCommand& command) {
  const bool is_pose = modes_.generator == MotionGeneratorMode::kCartesianPosition;
  const double cutoff_hz =
      is_pose ? filters_.cartesian_position_hz : filters_.cartesian_velocity_hz;
  const Vector6 acceleration = CartesianAcceleration(state, settles);
  Vector6 twist = state.O_dP_EE_c;
  for (std::size_t i = 0; i < 6; ++i) twist[i] += kT * acceleration[i];
  if (is_pose) {
    command.O_T_EE_c = After(state.O_T_EE_c, Unfiltered(twist, Vector6{}, cutoff_hz));
  } else {
    command.O_dP_EE_c = Unfiltered(twist, state.O_dP_EE_c, cutoff_hz);
  }
  if (!with_elbow_) return;
  const double delbow = state.delbow_c[0] + kT * ElbowAcceleration(state, settles);
  command.valid_elbow = true;
  command.elbow_c = {Unfiltered(state.elbow_c[0] + kT * delbow, state.elbow_c[0], cutoff_hz),
                     state.elbow_c[1]};
}

void StreamSource::FillTorque(const RobotState& state, RobotCommand& command) {
  for (std::size_t i = 0; i < kJoints; ++i) {
    const bool edge = has_edge_ && edge_.axis == i && edge_.edge == Edge::kJerk;
    double rate = 0.3 * vigour_ * joints_.dtau_max[i] * tau_rate_[i];
    if (edge) rate = std::copysign(edge_.size * joints_.dtau_max[i], rate);
    const double tau = state.tau_J_d[i] + kT * rate;
    const double most = edge ? 100 : 20;
    command.tau_J_d[i] =
        Unfiltered(std::clamp(tau, -most, most), state.tau_J_d[i], filters_.controller_hz);
  }
}

RobotCommand StreamSource::Next(const RobotState& state, bool settles) {
  if (cycles_to_draw_-- <= 0) DrawTargets();
  RobotCommand command;
  command.message_id = state.message_id;
  if (IsCartesian(modes_.generator)) {
    FillCartesian(state, settles, command);
  } else {
    FillJoints(state, settles, command);
  }
  if (modes_.controller == ControllerMode::kExternalController) FillTorque(state, command);
  return command;
}

bool StreamSource::MayFinish(const RobotState& s) const {
  double worst = 0;
  for (std::size_t i = 0; i < kJoints; ++i) {
    const double stop = std::abs(s.dq_d[i]) / kT;
    worst = std::max(worst, stop / joints_.ddq_max[i]);
    worst = std::max(worst, (stop + std::abs(s.ddq_d[i])) / kT / joints_.dddq_max[i]);
  }
  if (!IsCartesian(modes_.generator)) return worst < 0.5;
  const auto examine = [&](double v, double a, const CartesianBound& bound) {
    worst = std::max(worst, v / kT / bound.ddp_max);
    worst = std::max(worst, (v / kT + a) / kT / bound.dddp_max);
  };
  examine(Norm(Linear(s.O_dP_EE_c)), Norm(Linear(s.O_ddP_EE_c)), cartesian_.translation);
  examine(Norm(Angular(s.O_dP_EE_c)), Norm(Angular(s.O_ddP_EE_c)), cartesian_.rotation);
  examine(std::abs(s.delbow_c[0]), std::abs(s.ddelbow_c[0]), cartesian_.elbow);
  return worst < 0.5;
}

}  // namespace twin::test
