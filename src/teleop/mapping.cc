#include "twin/teleop/mapping.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <Eigen/Core>

#include "twin/model/transform.h"

namespace twin::teleop {
namespace {

using Eigen::Vector3d;

Vector3d Half(const Vector6& x, std::size_t first) {
  return {x[first], x[first + 1], x[first + 2]};
}

Eigen::Matrix3d RotationOf(const Transform& X) {
  return model::Orientation(X).toRotationMatrix();
}

bool IsFinite(const Vector6& x) {
  return std::ranges::all_of(x, [](double value) { return std::isfinite(value); });
}

bool IsOdd(std::uint32_t presses) {
  return presses % 2 == 1;
}

}  // namespace

void Mapping::Begin(bool has_base) noexcept {
  *this = Mapping(config_, full_);
  has_base_ = has_base;
}

void Mapping::Count(const OperatorSample& sample) noexcept {
  const bool turns_joints = JointOf(sample) != 0;
  if (sample.kind != last_.kind || turns_joints != (JointOf(last_) != 0)) is_open_ = false;
  const auto since = [&](std::uint32_t OperatorSample::*counter) {
    return PressesSince(last_.*counter, sample.*counter);
  };
  if (IsOdd(since(&OperatorSample::mode_presses)) && has_base_) {
    wanted_ = wanted_ == Mode::kArm ? Mode::kBase : Mode::kArm;
    is_open_ = false;
  }
  if (IsOdd(since(&OperatorSample::frame_presses))) {
    in_tool_frame_ = !in_tool_frame_;
    is_open_ = false;
  }
  if (IsOdd(since(&OperatorSample::scale_presses))) {
    fine_ = !fine_;
    is_open_ = is_open_ && sample.kind == AxisKind::kRate;
  }
  if (since(&OperatorSample::release_presses) > 0 && stopped_) {
    stopped_ = false;
    is_open_ = false;
  }
  stopped_ = stopped_ || since(&OperatorSample::stop_presses) > 0;
  ends_ = ends_ || since(&OperatorSample::end_presses) > 0;
  gripper_presses_ += since(&OperatorSample::gripper_presses);
  last_ = sample;
}

bool Mapping::Open(const OperatorSample& sample, const Situation& situation) noexcept {
  const bool leads = situation.connected && !stopped_ && !ends_ && mode_ == wanted_ &&
                     sample.engaged && IsFinite(sample.axes);
  awaits_release_ = false;
  if (!leads) return is_open_ = false;
  if (is_open_) return true;
  if (sample.kind == AxisKind::kPose) {
    handle_0_ = sample.axes;
    O_T_EE_0_ = situation.O_T_EE_d;
    return is_open_ = true;
  }
  is_open_ = std::ranges::all_of(sample.axes,
                                 [this](double x) { return std::abs(x) <= config_.dead_zone; });
  awaits_release_ = !is_open_;
  return is_open_;
}

Wish Mapping::Update(const OperatorSample& sample, const Situation& situation) noexcept {
  if (sample.sequence > 0) Count(sample);
  const bool rests = mode_ == Mode::kArm ? situation.arm_rests : situation.base_rests;
  if (rests) {
    mode_ = wanted_;
    joint_ = JointOf(last_);
  }
  Wish wish{.joint = joint_};
  if (!Open(sample, situation) || is_switching()) return wish;
  if (mode_ == Mode::kBase) {
    wish.base = Drive(sample);
  } else if (joint_ != 0) {
    wish.turn = scale() * full_.joint * Deflection(sample.axes[0]);
  } else if (sample.kind == AxisKind::kPose) {
    wish.pose = ArmPose(sample);
  } else {
    wish.twist = ArmTwist(sample, situation.O_T_EE_d);
  }
  return wish;
}

double Mapping::Deflection(double x) const noexcept {
  const double beyond = (std::abs(x) - config_.dead_zone) / (1 - config_.dead_zone);
  return std::copysign(std::clamp(beyond, 0.0, 1.0), x);
}

Vector6 Mapping::ArmTwist(const OperatorSample& sample, const Transform& O_T_EE_d) const noexcept {
  Vector3d v;
  Vector3d w;
  for (Eigen::Index i = 0; i < 3; ++i) {
    const auto axis = static_cast<std::size_t>(i);
    v[i] = scale() * full_.along * Deflection(sample.axes[axis]);
    w[i] = scale() * full_.about * Deflection(sample.axes[axis + 3]);
  }
  if (in_tool_frame_) {
    const Eigen::Matrix3d R = RotationOf(O_T_EE_d);
    v = R * v;
    w = R * w;
  }
  return {v[0], v[1], v[2], w[0], w[1], w[2]};
}

Transform Mapping::ArmPose(const OperatorSample& sample) const noexcept {
  const double share = scale() * config_.pose_scale;
  Vector3d way = share * (Half(sample.axes, 0) - Half(handle_0_, 0));
  const Eigen::Quaterniond turned =
      model::Exp(Half(sample.axes, 3)) * model::Exp(Half(handle_0_, 3)).conjugate();
  Vector3d turn = scale() * model::Log(turned);
  if (in_tool_frame_) {
    const Eigen::Matrix3d R = RotationOf(O_T_EE_0_);
    way = R * way;
    turn = R * turn;
  }
  return model::Turned(O_T_EE_0_, turn, model::Position(O_T_EE_0_) + way);
}

BaseTwist Mapping::Drive(const OperatorSample& sample) const noexcept {
  double ahead = 0;
  double left = 0;
  if (sample.kind == AxisKind::kRate) {
    ahead = Deflection(sample.axes[0]);
    left = Deflection(sample.axes[1]) + Deflection(sample.axes[5]);
  } else {
    ahead = Deflection((sample.axes[0] - handle_0_[0]) / config_.full_way);
    left = Deflection((sample.axes[1] - handle_0_[1]) / config_.full_way) +
           Deflection((sample.axes[5] - handle_0_[5]) / config_.full_turn);
  }
  return {.v = scale() * full_.ahead * ahead,
          .w = scale() * full_.turning * std::clamp(left, -1.0, 1.0)};
}

}  // namespace twin::teleop
