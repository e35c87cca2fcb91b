#include "twin/onboard/motion_generator.h"

#include <cmath>
#include <optional>
#include <tuple>

#include "onboard/bounds.h"
#include "twin/onboard/cartesian_monitor.h"
#include "twin/onboard/goal_approach.h"
#include "twin/onboard/joint_reference.h"
#include "twin/onboard/limit_monitor.h"

namespace twin::onboard {

MotionGenerator::MotionGenerator(const GeneratorLimits& limits, const JointVector& q0)
    : limits_(limits), filters_(Of(setting::Filters())) {
  Lead(JointReference::Rest(q0));
}

MotionGenerator::Filters MotionGenerator::Of(const setting::Filters& filters) {
  return {.joint_position = reference::LowPass(filters.joint_position_hz),
          .joint_velocity = reference::LowPass(filters.joint_velocity_hz),
          .cartesian_position = reference::LowPass(filters.cartesian_position_hz),
          .cartesian_velocity = reference::LowPass(filters.cartesian_velocity_hz)};
}

void MotionGenerator::SetEndEffector(const Transform& F_T_EE) noexcept {
  F_T_EE_ = F_T_EE;
  completion_ = KinematicCompletion(F_T_EE);
  Lead(joints_);
}

void MotionGenerator::SetFilters(const setting::Filters& filters) noexcept {
  filters_ = Of(filters);
}

bool MotionGenerator::IsSingular() const noexcept {
  return completion_.IsSingular(joints_.q_d);
}

void MotionGenerator::Start(const MotionModes& modes) noexcept {
  mode_ = modes.generator;
  asynchronous_ = modes.asynchronous;
  goal_ = joints_.q_d;
  has_elbow_ = false;
  lag_ = {};
  Rest();
}

void MotionGenerator::Rest() noexcept {
  Lead(JointReference::Rest(joints_.q_d));
}

Violations MotionGenerator::Take(const RobotCommand& command, bool is_first,
                                 std::uint64_t message_id) noexcept {
  return IsCartesian(mode_) ? TakeCartesian(command, is_first, message_id)
                            : TakeJoints(command, is_first, message_id);
}

Violations MotionGenerator::Hold(std::uint64_t message_id) noexcept {
  if (asynchronous_) return Approach(message_id);
  return IsCartesian(mode_) ? AdvanceCartesian(cartesian_.AfterLoss(), has_elbow_, message_id)
                            : AdvanceJoints(joints_.AfterLoss(), message_id);
}

Violations MotionGenerator::TakeJoints(const RobotCommand& command, bool is_first,
                                       std::uint64_t message_id) noexcept {
  if (asynchronous_) {
    // libfranka ends these motions with positions of zero.
    return command.motion_generation_finished ? Approach(message_id)
                                              : TakeGoal(command.q_c, message_id);
  }
  if (mode_ == MotionGeneratorMode::kNone) {
    return AdvanceJoints(joints_.AfterVelocity({}), message_id);
  }
  if (mode_ == MotionGeneratorMode::kJointVelocity) {
    const JointVector dq_c = filters_.joint_velocity.Filter(command.dq_c, joints_.dq_d);
    return AdvanceJoints(joints_.AfterVelocity(dq_c), message_id);
  }
  const JointVector q_c = filters_.joint_position.Filter(command.q_c, joints_.q_d);
  if (is_first) {
    const Violations found = CheckStartPosition(q_c, message_id);
    if (!found.empty()) return found;
  }
  return AdvanceJoints(joints_.AfterPosition(q_c), message_id);
}

Violations MotionGenerator::TakeGoal(const JointVector& q_c, std::uint64_t message_id) noexcept {
  const JointLimits& limits = limits_.joints;
  Violations found;
  internal::CheckJointRanges(RobotError::kJointMotionGeneratorPositionLimitsViolation, q_c,
                             limits.q_min, limits.q_max, message_id, found);
  if (!found.empty()) return found;
  goal_ = q_c;
  return Approach(message_id);
}

Violations MotionGenerator::Approach(std::uint64_t message_id) noexcept {
  return AdvanceJoints(ApproachStep(joints_, goal_, *asynchronous_, own_limits()), message_id);
}

Violations MotionGenerator::CheckStartPosition(const JointVector& q_c,
                                               std::uint64_t message_id) const noexcept {
  Violations found;
  for (std::size_t i = 0; i < kJoints; ++i) {
    const double distance = std::abs(q_c[i] - joints_.q_d[i]);
    if (internal::IsWithin(distance, limits_.start_q_rad)) continue;
    found.Add({RobotError::kJointPositionMotionGeneratorStartPoseInvalid,
               static_cast<std::int8_t>(i), distance, limits_.start_q_rad, message_id});
    break;
  }
  return found;
}

Violations MotionGenerator::TakeCartesian(const RobotCommand& command, bool is_first,
                                          std::uint64_t message_id) noexcept {
  if (mode_ == MotionGeneratorMode::kCartesianPosition) {
    const Violations found = CheckFrame(command.O_T_EE_c, message_id);
    if (!found.empty()) return found;
  }
  const CartesianReference next = Commanded(command);
  const Violations found = CheckCommand(command, next, is_first, message_id);
  return found.empty() ? AdvanceCartesian(next, command.valid_elbow, message_id) : found;
}

CartesianReference MotionGenerator::Commanded(const RobotCommand& command) const noexcept {
  const bool is_pose = mode_ == MotionGeneratorMode::kCartesianPosition;
  const reference::LowPass& filter =
      is_pose ? filters_.cartesian_position : filters_.cartesian_velocity;
  const CartesianReference next =
      is_pose ? cartesian_.AfterPose(filter.FilterPose(command.O_T_EE_c, cartesian_.O_T_EE_c))
              : cartesian_.AfterTwist(filter.Filter(command.O_dP_EE_c, cartesian_.O_dP_EE_c));
  if (!command.valid_elbow) return next;
  const double angle = filter.Filter(command.elbow_c[0], cartesian_.elbow_c[0]);
  return next.WithElbow({angle, command.elbow_c[1]}, cartesian_);
}

Violations MotionGenerator::CheckCommand(const RobotCommand& command,
                                         const CartesianReference& next, bool is_first,
                                         std::uint64_t message_id) const noexcept {
  const StartTolerance tolerance{.translation_m = limits_.start_translation_m,
                                 .rotation_rad = limits_.start_rotation_rad,
                                 .elbow_rad = limits_.start_elbow_rad};
  Violations found;
  if (is_first && mode_ == MotionGeneratorMode::kCartesianPosition) {
    found = CheckStartPose(next.O_T_EE_c, cartesian_.O_T_EE_c, tolerance, message_id);
  }
  if (!command.valid_elbow) return found;
  if (!has_elbow_) {
    found.Add(CheckStartElbow(next.elbow_c[0], cartesian_.elbow_c[0], tolerance, message_id));
  }
  if (!found.empty()) return found;
  return CheckElbowSign(command.elbow_c[1], model::ElbowOf(joints_.q_d)[1], message_id);
}

Violations MotionGenerator::AdvanceJoints(const JointReference& next,
                                          std::uint64_t message_id) noexcept {
  const Violations found = CheckStep(next, limits_.joints, message_id);
  if (found.empty()) Lead(next);
  return found;
}

Violations MotionGenerator::AdvanceCartesian(const CartesianReference& next, bool has_elbow,
                                             std::uint64_t message_id) noexcept {
  const Violations beyond =
      CheckCartesianStep(next, has_elbow, limits_.cartesian, limits_.joints, message_id);
  if (!beyond.empty()) return beyond;
  const std::optional<double> elbow = has_elbow ? std::optional(next.elbow_c[0]) : std::nullopt;
  const KinematicCompletion::Step step = completion_.Complete(joints_, lag_, next.O_T_EE_c, elbow);
  const JointReference joints = joints_.AfterPosition(step.q_d);
  const Violations found = CheckStep(joints, limits_.joints, message_id, kInverseKinematicsErrors);
  if (!found.empty()) return found;
  joints_ = joints;
  cartesian_ = has_elbow ? next : next.WithElbowOf(joints);
  has_elbow_ = has_elbow;
  lag_ = step.lag;
  O_T_EE_d_ = step.O_T_EE_d;
  O_dP_EE_d_ = step.O_dP_EE_d;
  return found;
}

CartesianReference MotionGenerator::Still(const CartesianReference& cartesian,
                                          const JointReference& joints) const noexcept {
  const CartesianReference next = cartesian.AfterPose(cartesian.O_T_EE_c);
  return has_elbow_ ? next.WithElbow(cartesian.elbow_c, cartesian) : next.WithElbowOf(joints);
}

Violations MotionGenerator::CheckBothSides(const CartesianReference& cartesian,
                                           const JointReference& joints,
                                           std::uint64_t message_id) const noexcept {
  if (!IsCartesian(mode_)) return CheckStep(joints, limits_.joints, message_id);
  const Violations found =
      CheckCartesianStep(cartesian, has_elbow_, limits_.cartesian, limits_.joints, message_id);
  if (!found.empty()) return found;
  return CheckStep(joints, limits_.joints, message_id, kInverseKinematicsErrors);
}

Violations MotionGenerator::CheckStandingStill(std::uint64_t message_id) const noexcept {
  const JointReference first = joints_.AfterPosition(joints_.q_d);
  const CartesianReference first_pose = Still(cartesian_, first);
  const Violations found = CheckBothSides(first_pose, first, message_id);
  if (!found.empty()) return found;
  const JointReference second = first.AfterPosition(first.q_d);
  return CheckBothSides(Still(first_pose, second), second, message_id);
}

void MotionGenerator::StandStill() noexcept {
  const CartesianReference before = cartesian_;
  Lead(joints_.AfterPosition(joints_.q_d));
  if (IsCartesian(mode_)) cartesian_ = Still(before, joints_);
}

void MotionGenerator::Brake() noexcept {
  mode_ = MotionGeneratorMode::kIdle;
  asynchronous_.reset();
  Lead(StopStep(joints_, own_limits()));
}

void MotionGenerator::TakeOver(const JointVector& q, const JointVector& dq) noexcept {
  mode_ = MotionGeneratorMode::kIdle;
  JointReference joints = JointReference::Rest(q);
  joints.dq_d = dq;
  Lead(joints);
}

bool MotionGenerator::AtRest() const noexcept {
  return joints_.AtRest() && cartesian_.AtRest();
}

/// The joint reference leads; pose and elbow follow from it.
void MotionGenerator::Lead(const JointReference& joints) noexcept {
  const model::ArmModel& arm = model::ArmModel::Panda();
  joints_ = joints;
  std::tie(O_T_EE_d_, O_dP_EE_d_) =
      arm.PoseAndTwist(model::Frame::kEndEffector, joints.q_d, joints.dq_d, F_T_EE_);
  cartesian_ = CartesianReference::Rest(O_T_EE_d_, model::ElbowOf(joints.q_d));
  cartesian_.O_dP_EE_c = O_dP_EE_d_;
  cartesian_ = cartesian_.WithElbowOf(joints);
}

}  // namespace twin::onboard
