#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "conformance/completion_oracle.h"
#include "conformance/pose_math.h"
#include "conformance/state_checker.h"
#include "twin/core/time.h"

// What StateChecker expects of a running motion.

namespace twin::test {
namespace {

/// The largest step of the internal controller's torque that a motion may begin with, Nm.
constexpr double kTorqueStep = 1.0;

bool IsExternal(const MotionModes& modes) {
  return modes.controller == ControllerMode::kExternalController;
}

/// The errors of Cartesian motions after inverse kinematics, where that cannot be recomputed.
Verdict AnyCompletionError() {
  Verdict verdict;
  for (const RobotError error :
       {RobotError::kCartesianMotionGeneratorJointPositionLimitsViolation,
        RobotError::kCartesianMotionGeneratorJointVelocityLimitsViolation,
        RobotError::kCartesianMotionGeneratorJointVelocityDiscontinuity,
        RobotError::kCartesianMotionGeneratorJointAccelerationDiscontinuity}) {
    verdict.Allow(error);
  }
  return verdict;
}

}  // namespace

void StateChecker::Count(bool served) {
  window_ <<= 1;
  window_.set(0, served);
  counted_ = std::min<std::size_t>(counted_ + 1, window_.size());
  lost_in_row_ = served ? 0 : lost_in_row_ + 1;
}

void StateChecker::CheckSuccessRate(const RobotState& s) {
  std::size_t received = 0;
  for (std::size_t i = 0; i < counted_; ++i) received += window_[i] ? 1 : 0;
  const double share =
      counted_ == 0 ? 0 : static_cast<double>(received) / static_cast<double>(counted_);
  if (std::abs(s.control_command_success_rate - share) > 1e-12) {
    Note(fmt::format("success rate {}, should be {}", s.control_command_success_rate, share));
  }
}

void StateChecker::CheckMotion(const RobotState& s) {
  BeginCycle();
  if (s.robot_mode == RobotMode::kReflex) {
    CheckAbort(s);
    return;
  }
  const Verdict verdict = JudgeCycle(s, false);
  if (verdict.must_abort()) {
    Note(fmt::format("goes on in spite of {}", FormatErrors(verdict.may())));
  }
  if (s.robot_mode == RobotMode::kIdle) {
    CheckEnd(s);
    return;
  }
  if (s.robot_mode != RobotMode::kMove || s.motion_generator_mode != modes_.generator ||
      s.controller_mode != modes_.controller) {
    Note(fmt::format("mode {}, generator {}, controller {} while a motion runs", Name(s.robot_mode),
                     Name(s.motion_generator_mode), Name(s.controller_mode)));
  }
  CheckCycle(s);
}

void StateChecker::BeginCycle() {
  // A command for a state before the motion is left over from another.
  if (phase_ == Phase::kRequested) command_.reset();
  const bool begins = phase_ == Phase::kRequested || phase_ == Phase::kStarting;
  if (begins && !command_) ++waited_;
  const bool counts = phase_ == Phase::kRunning || (phase_ == Phase::kStarting && command_);
  if (!counts) return;
  Count(command_.has_value());
  if (IsCartesian()) {
    cartesian_step_ = command_ ? CartesianStep(last_, *command_, modes_.generator, robot_.filters)
                               : HeldCartesianStep(last_, has_elbow_);
    const bool is_due = last_.message_id % 16 == 0 || cartesian_step_.has_elbow != has_elbow_;
    if (is_due) is_regular_ = IsRegular(last_.q_d, !cartesian_step_.has_elbow);
  } else {
    joint_step_ = command_ ? JointStep(last_, *command_, modes_.generator, robot_.filters)
                           : HeldJointStep(last_);
  }
}

Verdict StateChecker::JudgeCycle(const RobotState& s, bool in_detail) const {
  Verdict verdict = JudgeMotionMeasured(in_detail);
  const bool waits_too_long =
      phase_ == Phase::kStarting && !command_ &&
      waited_ >= static_cast<int>(robot_.limits.first_command_timeout_cycles);
  const bool lost_too_many = phase_ == Phase::kRunning && !command_ &&
                             lost_in_row_ >= static_cast<int>(robot_.limits.abort_after_lost);
  if (waits_too_long || lost_too_many) {
    Verdict lost;
    lost.Raise(RobotError::kCommunicationConstraintsViolation);
    verdict.Then(lost);
  } else if (phase_ == Phase::kRunning || (phase_ == Phase::kStarting && command_)) {
    verdict.Then(JudgeStep(in_detail));
  } else if (phase_ == Phase::kPreempting && !IsExternal(modes_)) {
    verdict.Then(JudgePreempted(s));
  }
  return verdict;
}

/// A ramp of the robot's own: an abort goes on with it, so that the state shows what it is for.
Verdict StateChecker::JudgePreempted(const RobotState& s) const {
  const JointLimits& limits = robot_.limits.joints;
  const RobotError error = IsCartesian()
                               ? RobotError::kCartesianMotionGeneratorJointPositionLimitsViolation
                               : RobotError::kJointMotionGeneratorPositionLimitsViolation;
  Verdict verdict;
  verdict.Examine({error, kJoints, s.q_d, limits.q_min, limits.q_max, 0});
  return verdict;
}

Verdict StateChecker::JudgeMotionMeasured(bool in_detail) const {
  Verdict verdict = JudgeCollisions(last_, robot_.collision_behavior);
  verdict.Beside(JudgeMeasured(last_, robot_.measured, IsCartesian()));
  // The distance between links is dear to compute, and changes little in some cycles.
  if (in_detail || last_.message_id % 16 == 0) {
    verdict.Beside(JudgeSelfCollision(last_, robot_.measured));
  }
  return verdict;
}

Verdict StateChecker::JudgeStep(bool in_detail) const {
  Verdict verdict;
  if (command_) {
    verdict = JudgeShape(last_, *command_, modes_.generator, phase_ == Phase::kStarting, has_elbow_,
                         robot_.filters, robot_.limits);
  }
  if (verdict.must_abort()) {
    // What is no command at all has no step.
  } else if (IsCartesian()) {
    verdict.Then(JudgeCartesianStep(in_detail));
  } else {
    verdict.Then(JudgeJointStep());
  }
  if (command_ && IsExternal(modes_)) {
    verdict.Beside(
        JudgeTorque(TorqueStep(last_, *command_, robot_.filters), last_, robot_.limits.joints));
  }
  return verdict;
}

Verdict StateChecker::JudgeJointStep() const {
  const JointLimits& limits = robot_.limits.joints;
  Verdict verdict = JudgeJoints(joint_step_, limits);
  if (!command_ || !command_->motion_generation_finished) return verdict;
  const JointMotion first = Standing(joint_step_);
  verdict.Then(JudgeJoints(first, limits));
  verdict.Then(JudgeJoints(Standing(first), limits));
  return verdict;
}

Verdict StateChecker::JudgeCartesianStep(bool in_detail) const {
  const bool finishes = command_ && command_->motion_generation_finished;
  Verdict verdict = JudgeCartesian(cartesian_step_, robot_.limits);
  JointMotion joints;
  const bool known = in_detail && !verdict.must_abort() && !IsLagging() &&
                     IsRegular(last_.q_d, !cartesian_step_.has_elbow);
  const auto completion = [&](const JointMotion& step) {
    const double noise = CompletionNoise(step) + 10 * cartesian_step_.oblique;
    return known ? JudgeCompletion(step, robot_.limits.joints, noise) : AnyCompletionError();
  };
  if (known) joints = Completed();
  verdict.Then(completion(joints));
  if (!finishes) return verdict;
  const CartesianMotion first = Standing(cartesian_step_);
  const JointMotion first_joints = Standing(joints);
  verdict.Then(JudgeCartesian(first, robot_.limits));
  verdict.Then(completion(first_joints));
  verdict.Then(JudgeCartesian(Standing(first), robot_.limits));
  verdict.Then(completion(Standing(first_joints)));
  return verdict;
}

/// What inverse kinematics makes of the Cartesian step.
JointMotion StateChecker::Completed() const {
  const std::optional<double> elbow =
      cartesian_step_.has_elbow ? std::optional(cartesian_step_.elbow) : std::nullopt;
  return JointStepTo(last_, Complete(last_.q_d, last_.F_T_EE, cartesian_step_.pose, elbow));
}

/// Whether the arm has not reached the commanded pose.
bool StateChecker::IsLagging() const {
  const Vector6 way = TwistBetween(last_.O_T_EE_d, last_.O_T_EE_c);
  return Norm(Linear(way)) + Norm(Angular(way)) > 1e-10 / kCycleSeconds;
}

void StateChecker::CheckAbort(const RobotState& s) {
  const Verdict verdict = JudgeCycle(s, true);
  const bool known = (s.errors & ~verdict.may()).none() && (verdict.must() & ~s.errors).none();
  if (s.errors.none() || !known) {
    Note(fmt::format("aborted for {}; recomputed: {} for certain, {} possible",
                     FormatErrors(s.errors), FormatErrors(verdict.must()),
                     FormatErrors(verdict.may())));
  }
  CheckDetails(s, verdict);
  reason_ = s.errors;
  situation_.has_errors = true;
  Become(RobotMode::kReflex);
  phase_ = Phase::kNone;
  braking_ = 0;
  longest_braking_ = LongestBraking(last_, robot_.brakes_by());
  took_over_ = external_acts_;
  external_acts_ = false;
  CheckComingToRest(s);
  took_over_ = false;
}

void StateChecker::CheckDetails(const RobotState& s, const Verdict& verdict) {
  const backend::Description told = describe_();
  if (told.last_end != backend::MotionEnd::kAborted || told.last_errors != s.errors) {
    Note(fmt::format("the description tells of errors {}", FormatErrors(told.last_errors)));
  }
  RobotErrors explained;
  for (const Violation& violation : told.violations) {
    explained.set(static_cast<std::size_t>(violation.error));
    if (violation.message_id != s.message_id) {
      Note(fmt::format("{} is of cycle {}", Name(violation.error), violation.message_id));
    }
    Note(verdict.FindOtherValue(violation));
  }
  if (explained != s.errors) Note("not every error has its violation");
}

void StateChecker::CheckCycle(const RobotState& s) {
  switch (phase_) {
    case Phase::kRequested:
      Note(FindUnrest(last_, s));
      phase_ = Phase::kStarting;
      break;
    case Phase::kStarting: command_ ? CheckTaken(s) : Note(FindUnrest(last_, s)); break;
    case Phase::kRunning: command_ ? CheckTaken(s) : CheckHeld(s); break;
    case Phase::kFinishing:
      if (IsExternal(modes_)) CheckComingToRest(s);
      took_over_ = false;
      if (!IsExternal(modes_)) Note(FindBeyondLimits(last_, s, robot_.limits.joints));
      if (++braking_ > longest_braking_) Note("a finished motion does not end");
      return;
    case Phase::kPreempting:
      took_over_ = external_acts_;
      external_acts_ = false;
      CheckComingToRest(s);
      took_over_ = false;
      return;
    case Phase::kNone: return;
  }
  CheckSuccessRate(s);
  if (external_acts_ || !robot_.is_ideal) return;
  for (std::size_t i = 0; i < kJoints; ++i) {
    if (phase_ == Phase::kStarting && std::abs(s.tau_J_d[i] - last_.tau_J_d[i]) > kTorqueStep) {
      Note(fmt::format("tau_J_d[{}] steps from {} to {}", i, last_.tau_J_d[i], s.tau_J_d[i]));
    }
  }
}

void StateChecker::CheckTaken(const RobotState& s) {
  if (IsCartesian()) {
    Note(FindOffStep(cartesian_step_, s));
    CheckCompletion(s);
  } else {
    Note(FindOffStep(joint_step_, s));
  }
  Note(FindBeyondLimits(last_, s, robot_.limits.joints));
  phase_ = Phase::kRunning;
  has_elbow_ = IsCartesian() && command_->valid_elbow;
  if (IsExternal(modes_)) CheckTakenTorque(s);
  if (!command_->motion_generation_finished) return;
  phase_ = Phase::kFinishing;
  braking_ = 0;
  longest_braking_ = LongestBraking(s, robot_.brakes_by());
  took_over_ = external_acts_;
  external_acts_ = false;
}

void StateChecker::CheckTakenTorque(const RobotState& s) {
  external_acts_ = true;
  const JointVector tau = TorqueStep(last_, *command_, robot_.filters);
  for (std::size_t i = 0; i < kJoints; ++i) {
    if (std::abs(s.tau_J_d[i] - tau[i]) <= 1e-12) continue;
    Note(fmt::format("tau_J_d[{}] is {:.17g}, commanded {:.17g}", i, s.tau_J_d[i], tau[i]));
  }
}

void StateChecker::CheckHeld(const RobotState& s) {
  if (IsCartesian()) {
    Note(FindOffStep(cartesian_step_, s));
    CheckCompletion(s);
  } else {
    Note(FindOffStep(joint_step_, s));
  }
  Note(FindBeyondLimits(last_, s, robot_.limits.joints));
  if (external_acts_ && s.tau_J_d != last_.tau_J_d) Note("a lost command changes the held torque");
}

void StateChecker::CheckCompletion(const RobotState& s) {
  Note(FindBrokenDifferences(last_, s));
  if (cartesian_step_.has_elbow && std::abs(s.q_d[2] - cartesian_step_.elbow) > 1e-14) {
    Note(fmt::format("joint 3 is at {:.17g}, the elbow is commanded to {:.17g}", s.q_d[2],
                     cartesian_step_.elbow));
  }
  if (!is_regular_ || IsLagging()) return;
  const Vector6 way = TwistBetween(s.O_T_EE_d, cartesian_step_.pose);
  const double off = (Norm(Linear(way)) + Norm(Angular(way))) * kCycleSeconds;
  if (off > 1e-9 + 2 * cartesian_step_.oblique)
    Note(fmt::format("the arm is {:.3g} m and rad off the commanded pose", off));
  if (s.message_id % 16 != 0) return;
  const JointMotion expected = Completed();
  const double noise = CompletionNoise(expected) + 10 * cartesian_step_.oblique;
  for (std::size_t i = 0; i < kJoints; ++i) {
    if (std::abs(s.q_d[i] - expected.q[i]) <= noise) continue;
    Note(fmt::format("q_d[{}] is {:.17g}, inverse kinematics gives {:.17g}", i, s.q_d[i],
                     expected.q[i]));
  }
}

void StateChecker::CheckEnd(const RobotState& s) {
  const bool may_end = phase_ == Phase::kFinishing || phase_ == Phase::kPreempting;
  const backend::MotionEnd expected =
      phase_ == Phase::kFinishing ? backend::MotionEnd::kSuccess : backend::MotionEnd::kPreempted;
  if (!may_end) Note("the motion ends by itself");
  if (may_end && describe_().last_end != expected) Note("the motion's end is told wrongly");
  if (!IsAtRest(s)) Note("the motion ends before the arm rests");
  if (phase_ == Phase::kPreempting || IsExternal(modes_)) {
    took_over_ = took_over_ || external_acts_;
    CheckComingToRest(s);
  }
  took_over_ = false;
  external_acts_ = false;
  phase_ = Phase::kNone;
  Become(RobotMode::kIdle);
}

}  // namespace twin::test
