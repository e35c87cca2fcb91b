#include "conformance/state_checker.h"

#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "conformance/completion_oracle.h"

namespace twin::test {
namespace {

/// States that may show recovery; INT's own figure is a decision of its own.
constexpr int kLongestRecovery = 1000;

/// External torque that an arm in motion may take for one, by its differences over a cycle, Nm.
constexpr double kNoTorque = 1;

/// Frames and load are those that were set.
Finding FindOtherSetup(const RobotState& set, const RobotState& s) {
  const bool same = s.F_T_NE == set.F_T_NE && s.NE_T_EE == set.NE_T_EE && s.EE_T_K == set.EE_T_K &&
                    s.m_ee == set.m_ee && s.F_x_Cee == set.F_x_Cee && s.I_ee == set.I_ee &&
                    s.m_load == set.m_load && s.F_x_Cload == set.F_x_Cload &&
                    s.I_load == set.I_load;
  return same ? Finding() : Finding("frames or load are not those that were set");
}

}  // namespace

StateChecker::StateChecker(const CheckedRobot& robot, Describe describe)
    : robot_(robot), describe_(std::move(describe)) {}

void StateChecker::Note(const Finding& finding) {
  if (finding && !finding_) {
    finding_ = fmt::format("cycle {}, after {}: {}", last_.message_id + 1, Name(last_.robot_mode),
                           *finding);
  }
}

bool StateChecker::IsCartesian() const {
  return modes_.generator == MotionGeneratorMode::kCartesianPosition ||
         modes_.generator == MotionGeneratorMode::kCartesianVelocity;
}

void StateChecker::Become(RobotMode mode) {
  situation_.mode = mode;
  if (mode == RobotMode::kOther) situation_.brakes_closed = true;
  recovering_ = 0;
}

void StateChecker::CheckRequest(Ask ask, bool accepted) {
  const Outcome expected = Expect(situation_, ask);
  if (accepted != expected.accepted) {
    Note(fmt::format("{} in mode {}, {}, was {}", Name(ask), Name(situation_.mode),
                     situation_.at_rest ? "at rest" : "moving", accepted ? "accepted" : "refused"));
  }
}

void StateChecker::OnStart(const MotionModes& modes, bool accepted) {
  const bool is_combination =
      modes.generator != MotionGeneratorMode::kIdle && modes.controller != ControllerMode::kOther;
  modes_ = phase_ == Phase::kNone ? modes : modes_;
  const bool may_be_singular =
      phase_ == Phase::kNone && IsCartesian() && !IsRegular(last_.q_d, true);
  if (!accepted && (!is_combination || may_be_singular)) return;
  CheckRequest(Ask::kMove, accepted);
  if (!accepted) return;
  Become(RobotMode::kMove);
  phase_ = Phase::kRequested;
  reason_.reset();
  external_acts_ = false;
  has_elbow_ = false;
  is_regular_ = false;
  waited_ = 0;
  lost_in_row_ = 0;
  window_.reset();
  counted_ = 0;
}

void StateChecker::OnRequest(Ask ask, bool accepted) {
  const bool needs_people = ask == Ask::kAutomaticErrorRecovery && !accepted &&
                            situation_.mode == RobotMode::kReflex &&
                            IsOutOfRange(last_.q, robot_.measured);
  if (needs_people) return;
  CheckRequest(ask, accepted);
  if (!accepted) return;
  const RobotMode before = situation_.mode;
  const RobotMode after = Expect(situation_, ask).mode;
  if (ask == Ask::kStopMove && phase_ != Phase::kNone) {
    phase_ = Phase::kPreempting;
    braking_ = 0;
    longest_braking_ = LongestBraking(last_, robot_.brakes_by());
  }
  if (ask == Ask::kPressUserStop && phase_ != Phase::kNone) {
    phase_ = Phase::kNone;
    user_stopped_ = true;
    braking_ = 0;
    longest_braking_ = LongestBraking(last_, robot_.brakes_by());
  }
  if (before == RobotMode::kOther && after != RobotMode::kOther) {
    situation_.brakes_closed = ask != Ask::kOpenBrakes;
  }
  if (after != before) Become(after);
  if (after == RobotMode::kAutomaticErrorRecovery) situation_.has_errors = false;
  // What people did to the arm in these modes is no collision any more, either.
  const bool was_held_up = before == RobotMode::kUserStopped || before == RobotMode::kGuiding ||
                           before == RobotMode::kOther;
  const bool is_let_go = was_held_up && after != before && ask != Ask::kPressUserStop;
  if (after != before && !situation_.has_errors &&
      (is_let_go || after == RobotMode::kAutomaticErrorRecovery)) {
    last_.joint_collision = JointVector{};
    last_.cartesian_collision = Vector6{};
  }
}

void StateChecker::OnSetting(const Setting& setting, bool accepted) {
  if (FindBadValue(setting)) {
    if (accepted) Note(fmt::format("{} accepted a bad value", twin::Name(setting)));
    return;
  }
  CheckRequest(Ask::kSet, accepted);
  if (!accepted) return;
  if (const auto* filters = std::get_if<setting::Filters>(&setting)) robot_.filters = *filters;
  if (const auto* behavior = std::get_if<setting::CollisionBehavior>(&setting)) {
    robot_.collision_behavior = *behavior;
  }
  if (const auto* frame = std::get_if<setting::EndEffectorFrame>(&setting)) {
    last_.NE_T_EE = frame->NE_T_EE;
  }
  if (const auto* frame = std::get_if<setting::StiffnessFrame>(&setting)) {
    last_.EE_T_K = frame->EE_T_K;
  }
  if (const auto* load = std::get_if<setting::Load>(&setting)) {
    load_was_set_ = true;
    last_.m_load = load->m_load;
    last_.F_x_Cload = load->F_x_Cload;
    last_.I_load = load->I_load;
  }
}

void StateChecker::OnCommand(const RobotCommand& command) {
  if (has_last_ && command.message_id == last_.message_id) command_ = command;
}

void StateChecker::OnState(const RobotState& s) {
  constexpr auto kHalted = static_cast<std::size_t>(RobotError::kInstabilityDetected);
  has_halted_ = has_halted_ || (!robot_.is_ideal && s.errors.test(kHalted));
  if (finding_ || has_halted_) return;
  if (!has_last_) {
    has_last_ = true;
    last_ = s;
    Note(FindNotFinite(s));
    CheckIdle(s);
    return;
  }
  if (s.message_id != last_.message_id + 1) {
    Note(fmt::format("message_id {} after {}", s.message_id, last_.message_id));
  }
  Note(FindNotFinite(s));
  CheckIdle(s);
  Note(FindInconsistency(last_, s));
  Note(FindOtherSetup(last_, s));
  Note(FindWrongFlags(last_, s, robot_.collision_behavior));
  if (s.message_id % 16 == 0) CheckExternal(s);
  if (phase_ != Phase::kNone) {
    CheckMotion(s);
  } else {
    CheckWithoutMotion(s);
  }
  CheckErrors(s);
  last_ = s;
  situation_.at_rest = IsAtRest(s);
  command_.reset();
}

void StateChecker::CheckIdle(const RobotState& s) {
  const bool moving = s.robot_mode == RobotMode::kMove;
  const double rate = s.control_command_success_rate;
  if (!(rate >= 0 && rate <= 1)) Note(fmt::format("success rate {}", rate));
  if (moving) return;
  if (s.motion_generator_mode != MotionGeneratorMode::kIdle ||
      s.controller_mode != ControllerMode::kOther || rate != 0) {
    Note(fmt::format("mode {} shows generator {}, controller {}, success rate {}",
                     Name(s.robot_mode), Name(s.motion_generator_mode), Name(s.controller_mode),
                     rate));
  }
}

void StateChecker::CheckExternal(const RobotState& s) {
  Note(FindWrongWrench(s));
  if (load_was_set_ || !robot_.is_ideal) return;
  for (std::size_t i = 0; i < kJoints; ++i) {
    if (std::abs(s.tau_ext_hat_filtered[i]) <= kNoTorque) continue;
    Note(fmt::format("tau_ext_hat_filtered[{}] is {} with nothing there", i,
                     s.tau_ext_hat_filtered[i]));
  }
}

void StateChecker::CheckMode(const RobotState& s) {
  if (situation_.mode == RobotMode::kAutomaticErrorRecovery) {
    // What is idle again can collide in the same cycle.
    const bool is_over = s.robot_mode == RobotMode::kIdle || s.robot_mode == RobotMode::kReflex;
    if (is_over && recovering_ > 0) Become(RobotMode::kIdle);
    if (++recovering_ > kLongestRecovery) Note("recovery does not end");
  }
  const bool collided = situation_.mode == RobotMode::kIdle && s.robot_mode == RobotMode::kReflex;
  if (collided) {
    const Verdict verdict = JudgeCollisions(last_, robot_.collision_behavior);
    if ((s.errors & ~verdict.may()).any() || s.errors.none()) {
      Note(fmt::format("Reflex out of Idle for {}", FormatErrors(s.errors)));
    }
    Become(RobotMode::kReflex);
    situation_.has_errors = true;
  }
  const bool ignored = situation_.mode == RobotMode::kIdle && !collided &&
                       JudgeCollisions(last_, robot_.collision_behavior).must_abort();
  if (ignored) Note("a collision while idle is ignored");
  if (s.robot_mode != situation_.mode) {
    Note(fmt::format("mode {}, should be {}", Name(s.robot_mode), Name(situation_.mode)));
  }
}

void StateChecker::CheckWithoutMotion(const RobotState& s) {
  CheckMode(s);
  if (user_stopped_) {
    user_stopped_ = false;
    if (describe_().last_end != backend::MotionEnd::kUserStopped) Note("not told as user-stopped");
    took_over_ = external_acts_;
    external_acts_ = false;
  }
  if (s.robot_mode == RobotMode::kGuiding) return;  // people move the reference
  CheckComingToRest(s);
  took_over_ = false;
}

void StateChecker::CheckComingToRest(const RobotState& s) {
  if (IsAtRest(last_) && !took_over_) {
    Note(FindUnrest(last_, s));
    return;
  }
  Note(FindBadBraking(last_, s, robot_.limits.joints, took_over_));
  if (!IsAtRest(s) && ++braking_ > longest_braking_) {
    Note(fmt::format("the arm still moves after {} cycles of braking", braking_));
  }
}

void StateChecker::CheckErrors(const RobotState& s) {
  const bool may_have = situation_.has_errors;
  if (s.errors.any() != may_have) {
    Note(fmt::format("errors {} in mode {}", FormatErrors(s.errors), Name(s.robot_mode)));
  }
  if (s.reflex_reason != reason_) {
    Note(fmt::format("reflex_reason {}, should be {}", FormatErrors(s.reflex_reason),
                     FormatErrors(reason_)));
  }
  const bool kept = last_.errors.any() && s.errors.any();
  if (kept && s.errors != last_.errors) Note("errors change while they last");
}

}  // namespace twin::test
