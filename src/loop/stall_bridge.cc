#include "twin/loop/stall_bridge.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "twin/core/time.h"

namespace twin::loop {
namespace {

using control::CommandInterface;

constexpr double kT = kCycleSeconds;
constexpr double kOmega = 6;  // 1/s

/// Once a source has stalled, what is more than this in a cycle is a jump. As a velocity it makes
/// 2 rad/s^2; as a position, corrected by lambda = 1e-3, a jerk of 500 rad/s^3.
constexpr double kVelocityJump = 2e-3;
constexpr double kPositionJump = 5e-4;
/// An offset this small is gone: as a velocity it makes a jerk of 1e-4.
constexpr double kGone = 1e-10;

Eigen::Map<const Eigen::Matrix4d> AsMatrix(const Transform& T) {
  return Eigen::Map<const Eigen::Matrix4d>(T.data());
}

/// Rotation vector that leads from `from` to `to`, base axes.
Eigen::Vector3d RotationBetween(const Transform& from, const Transform& to) {
  const Eigen::Matrix3d R =
      AsMatrix(to).topLeftCorner<3, 3>() * AsMatrix(from).topLeftCorner<3, 3>().transpose();
  const Eigen::AngleAxisd turn(R);
  return turn.angle() * turn.axis();
}

/// Turns `T` back by the rotation vector `turn`.
void TurnBack(const Eigen::Vector3d& turn, Transform& T) {
  const double angle = turn.norm();
  if (angle == 0) return;
  Eigen::Map<Eigen::Matrix4d> matrix(T.data());
  const Eigen::Matrix3d R = Eigen::AngleAxisd(-angle, turn / angle).toRotationMatrix();
  matrix.topLeftCorner<3, 3>() = (R * matrix.topLeftCorner<3, 3>()).eval();
}

}  // namespace

void StallBridge::Offset::Step() noexcept {
  static const double decay = std::exp(-kOmega * kT);
  const double drive = rate + kOmega * x;
  x = (x + drive * kT) * decay;
  rate = (rate - kOmega * drive * kT) * decay;
  if (std::abs(x) < kGone && std::abs(rate) < kGone) *this = Offset();
}

void StallBridge::Reset() noexcept {
  *this = StallBridge(interface_, period_cycles_);
}

void StallBridge::Bridge(Motion& motion, bool turns) noexcept {
  active_ = false;
  for (std::size_t i = 0; i < kJoints; ++i) {
    Offset& v = velocity_offset_[i];
    Offset& p = position_offset_[i];
    const double jump = motion.velocity[i] - last_velocity_[i];
    const double leap = motion.step[i] - kT * motion.velocity[i];
    if (turns || std::abs(jump) > kVelocityJump) v.x += jump;
    if (std::abs(leap) > kPositionJump) p.x += leap;
    last_velocity_[i] = motion.velocity[i];
    motion.velocity[i] -= v.x;
    v.Step();
    p.Step();
    active_ = active_ || stalled() || !v.gone() || !p.gone();
  }
}

StallBridge::Motion StallBridge::MotionOf(const reference::Target& target) const noexcept {
  Motion motion;
  switch (interface_) {
    case CommandInterface::kJointPosition:
      motion.velocity = target.joint.dq;
      for (std::size_t i = 0; i < kJoints; ++i) {
        motion.step[i] = target.joint.q[i] - last_.joint.q[i];
      }
      return motion;
    case CommandInterface::kCartesianPose: {
      std::ranges::copy(target.pose.O_dP_EE, motion.velocity.begin());
      const Eigen::Vector3d turn = RotationBetween(last_.pose.O_T_EE, target.pose.O_T_EE);
      for (std::size_t i = 0; i < 3; ++i) {
        motion.step[i] = target.pose.O_T_EE[12 + i] - last_.pose.O_T_EE[12 + i];
        motion.step[3 + i] = turn[static_cast<Eigen::Index>(i)];
      }
      return motion;
    }
    // These have no position that could leap: it is where the velocity leads.
    case CommandInterface::kJointVelocity: motion.velocity = target.joint.dq; break;
    case CommandInterface::kTorque: motion.velocity = target.tau_J_d; break;
  }
  for (std::size_t i = 0; i < kJoints; ++i) motion.step[i] = kT * motion.velocity[i];
  return motion;
}

reference::Target StallBridge::Carried(reference::Target target,
                                       const Values& velocity) const noexcept {
  switch (interface_) {
    case CommandInterface::kJointPosition:
      for (std::size_t i = 0; i < kJoints; ++i) target.joint.q[i] -= position_offset_[i].x;
      target.joint.dq = velocity;
      break;
    case CommandInterface::kJointVelocity: target.joint.dq = velocity; break;
    case CommandInterface::kTorque: target.tau_J_d = velocity; break;
    case CommandInterface::kCartesianPose:
      for (std::size_t i = 0; i < 3; ++i) target.pose.O_T_EE[12 + i] -= position_offset_[i].x;
      TurnBack({position_offset_[3].x, position_offset_[4].x, position_offset_[5].x},
               target.pose.O_T_EE);
      std::copy_n(velocity.begin(), target.pose.O_dP_EE.size(), target.pose.O_dP_EE.begin());
      break;
  }
  return target;
}

reference::Target StallBridge::Next(const reference::Target& target, bool fresh,
                                    std::uint64_t cycles) noexcept {
  const bool was_stalled = stalled();
  const bool late = fresh && waited_ > period_cycles_;
  waited_ = fresh ? 0 : waited_ + cycles;
  const bool turns = late || stalled() != was_stalled;
  if (!active_ && turns) last_velocity_ = MotionOf(last_).velocity;
  active_ = active_ || turns;
  if (!active_) {
    last_ = target;
    return target;
  }
  Motion motion = MotionOf(target);
  if (stalled()) motion = Motion();
  last_ = target;
  Bridge(motion, turns);
  return Carried(target, motion.velocity);
}

}  // namespace twin::loop
