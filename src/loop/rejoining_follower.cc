#include "twin/loop/rejoining_follower.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "twin/model/transform.h"

namespace twin::loop {
namespace {

using control::CommandInterface;
using reference::Played;

/// a + share * b.
JointVector Sum(const JointVector& a, double share, const JointVector& b) noexcept {
  JointVector sum{};
  for (std::size_t i = 0; i < kJoints; ++i) sum[i] = a[i] + share * b[i];
  return sum;
}

bool Near(const JointVector& a, const JointVector& b, double tolerance) noexcept {
  return std::ranges::equal(
      a, b, [tolerance](double x, double y) { return std::abs(x - y) <= tolerance; });
}

bool Near(const Transform& a, const Transform& b, double tolerance) noexcept {
  return (model::Position(a) - model::Position(b)).norm() <= tolerance &&
         model::TurnBetween(b, a).norm() <= tolerance;
}

}  // namespace

RejoiningFollower::RejoiningFollower(CommandInterface interface, double source_rate_hz,
                                     const JointLimits& joints, const CartesianLimits& cartesian)
    : interface_(interface),
      joints_(source_rate_hz, {.limit = joints.dddq_max,
                               .order = interface == CommandInterface::kJointVelocity ? 2 : 3}),
      poses_(source_rate_hz, cartesian),
      joint_generator_(joints),
      pose_generator_(cartesian) {}

void RejoiningFollower::Reset(const RobotState& state) noexcept {
  const bool by_velocity = interface_ == CommandInterface::kJointVelocity;
  joints_.Reset(by_velocity ? JointVector{} : state.q_d);
  poses_.Reset(state.O_T_EE_c);
  way_ = state.q_d;
  source_ = {};
}

void RejoiningFollower::Advance() noexcept {
  if (interface_ == CommandInterface::kCartesianPose) {
    poses_.Advance();
    return;
  }
  joints_.Advance();
  if (interface_ == CommandInterface::kJointVelocity)
    way_ = Sum(way_, joints_.step_s(), joints_.Value());
}

void RejoiningFollower::Observe(const RobotState& state, const reference::Target& target,
                                bool fresh, std::uint64_t cycles, Time source_time,
                                bool stalled) noexcept {
  constexpr std::uint64_t kMostCycles = 64;  // the robot ends a motion after 20 without a command
  const bool by_velocity = interface_ == CommandInterface::kJointVelocity;
  // The resampler measures a deposit's lag against the cycle that takes the deposit.
  for (std::uint64_t i = 1; i < std::min(cycles, kMostCycles); ++i) Advance();
  if (fresh && interface_ == CommandInterface::kCartesianPose) {
    poses_.Deposit(source_time, target.pose.O_T_EE);
  } else if (fresh) {
    joints_.Deposit(source_time, by_velocity ? target.joint.dq : target.joint.q);
  }
  stalled_ = stalled;
  if (stalled) {
    joints_.Stop();
    poses_.Stop();
  }
  Advance();
  if (stalled && by_velocity) way_ = state.q_d;
  source_ = target;
  if (interface_ == CommandInterface::kJointPosition) {
    source_.joint.q = joints_.Source();
    source_.joint.dq = Sum({}, 1 / kT, Sum(source_.joint.q, -1, joints_.Source(1)));
  } else if (interface_ == CommandInterface::kCartesianPose) {
    source_.pose.O_T_EE = poses_.Source();
  }
}

Played<JointVector> RejoiningFollower::Joints() const noexcept {
  if (interface_ == CommandInterface::kJointPosition) {
    return {joints_.Value(0), joints_.Value(1), joints_.Value(2), joints_.Value(3)};
  }
  Played<JointVector> r{way_, way_, way_, way_};
  if (stalled_) return r;
  for (std::size_t i = 1; i < r.size(); ++i)
    r[i] = Sum(r[i - 1], -joints_.step_s(), joints_.Value(i - 1));
  return r;
}

Played<Transform> RejoiningFollower::Poses() const noexcept {
  return {poses_.Value(0), poses_.Value(1), poses_.Value(2), poses_.Value(3)};
}

void RejoiningFollower::Command(const RobotState& state, RobotCommand& command) const noexcept {
  if (interface_ == CommandInterface::kCartesianPose) {
    command.O_T_EE_c = pose_generator_.Next(Poses(), state);
    return;
  }
  const JointVector q_c = joint_generator_.Next(Joints(), state.q_d, state.dq_d, state.ddq_d);
  if (interface_ == CommandInterface::kJointPosition) {
    command.q_c = q_c;
  } else {
    command.dq_c = Sum({}, 1 / kT, Sum(q_c, -1, state.q_d));
  }
}

bool RejoiningFollower::Arrived(const RobotState& state, double tolerance,
                                bool is_noisy) const noexcept {
  if (interface_ == CommandInterface::kCartesianPose) {
    const Transform r = poses_.Value();
    const Transform last = poses_.Value(1);
    return (r == last || (is_noisy && Near(r, last, tolerance))) &&
           Near(r, state.O_T_EE_c, tolerance);
  }
  const Played<JointVector> r = Joints();
  return (r[0] == r[1] || (is_noisy && Near(r[0], r[1], tolerance))) &&
         Near(r[0], state.q_d, tolerance);
}

}  // namespace twin::loop
