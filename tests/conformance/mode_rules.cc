#include "conformance/mode_rules.h"

namespace twin::test {
namespace {

constexpr std::array<std::string_view, kAsks> kNames{
    "Move",
    "Stop Move",
    "Set requests",
    "Automatic Error Recovery",
    "press_user_stop",
    "release_user_stop",
    "close_brakes",
    "open_brakes",
    "press_guiding_button",
    "release_guiding_button",
};

/// Where the robot goes when what held it up is gone.
RobotMode Resting(const Situation& situation) {
  if (situation.brakes_closed) return RobotMode::kOther;
  return situation.has_errors ? RobotMode::kReflex : RobotMode::kIdle;
}

/// Accepted, and the mode it leads to.
Outcome To(RobotMode mode) {
  return {true, mode};
}
/// Refused if `refused`, and then nothing changes.
Outcome Unless(bool refused, const Situation& situation, RobotMode mode) {
  return refused ? Outcome{false, situation.mode} : To(mode);
}

/// Moves start from Idle only, with the arm at rest.
Outcome OnMove(const Situation& s) {
  return Unless(s.mode != RobotMode::kIdle || !s.at_rest, s, RobotMode::kMove);
}

/// Always a success, as clients end their process on anything else. A motion goes on showing Move
/// while the arm decelerates.
Outcome OnStopMove(const Situation& s) {
  return To(s.mode);
}

/// Refused while something moves the arm by itself, and until an error is recovered from.
Outcome OnSetter(const Situation& s) {
  const bool refused = s.mode == RobotMode::kMove || s.mode == RobotMode::kReflex ||
                       s.mode == RobotMode::kAutomaticErrorRecovery;
  return Unless(refused, s, s.mode);
}

/// A success means that there is no error any more. With one it needs the arm at rest, and nobody
/// who holds the robot up; without one there is nothing to do.
Outcome OnRecovery(const Situation& s) {
  switch (s.mode) {
    case RobotMode::kReflex: return Unless(!s.at_rest, s, RobotMode::kAutomaticErrorRecovery);
    case RobotMode::kMove:
    case RobotMode::kUserStopped:
    case RobotMode::kAutomaticErrorRecovery: return {false, s.mode};
    case RobotMode::kOther:
    case RobotMode::kIdle:
    case RobotMode::kGuiding: return Unless(s.has_errors, s, s.mode);
  }
  return {};
}

/// The user stop works whatever the robot does.
Outcome OnPressUserStop(const Situation&) {
  return To(RobotMode::kUserStopped);
}

Outcome OnReleaseUserStop(const Situation& s) {
  if (s.mode != RobotMode::kUserStopped) return To(s.mode);
  return Unless(!s.at_rest, s, Resting(s));
}

/// Only an arm that stands still may be braked, and only one that nobody uses.
Outcome OnCloseBrakes(const Situation& s) {
  if (s.mode == RobotMode::kOther) return To(s.mode);
  const bool free = s.mode == RobotMode::kIdle || s.mode == RobotMode::kReflex;
  return Unless(!free || !s.at_rest, s, RobotMode::kOther);
}

Outcome OnOpenBrakes(const Situation& s) {
  if (s.mode == RobotMode::kUserStopped) return {false, s.mode};
  if (s.mode != RobotMode::kOther) return To(s.mode);
  return To(s.has_errors ? RobotMode::kReflex : RobotMode::kIdle);
}

/// From Idle, and from Reflex so that people can free the arm.
Outcome OnPressGuiding(const Situation& s) {
  if (s.mode == RobotMode::kGuiding) return To(s.mode);
  const bool free = s.mode == RobotMode::kIdle || s.mode == RobotMode::kReflex;
  return Unless(!free || !s.at_rest, s, RobotMode::kGuiding);
}

Outcome OnReleaseGuiding(const Situation& s) {
  return To(s.mode == RobotMode::kGuiding ? Resting(s) : s.mode);
}

}  // namespace

std::string_view Name(Ask ask) {
  return kNames[static_cast<std::size_t>(ask)];
}

Ask AskOf(PanelAction action) {
  switch (action) {
    case PanelAction::kPressUserStop: return Ask::kPressUserStop;
    case PanelAction::kReleaseUserStop: return Ask::kReleaseUserStop;
    case PanelAction::kCloseBrakes: return Ask::kCloseBrakes;
    case PanelAction::kOpenBrakes: return Ask::kOpenBrakes;
    case PanelAction::kPressGuidingButton: return Ask::kPressGuidingButton;
    case PanelAction::kReleaseGuidingButton: return Ask::kReleaseGuidingButton;
  }
  return Ask::kPressUserStop;
}

Outcome Expect(const Situation& situation, Ask ask) {
  switch (ask) {
    case Ask::kMove: return OnMove(situation);
    case Ask::kStopMove: return OnStopMove(situation);
    case Ask::kSet: return OnSetter(situation);
    case Ask::kAutomaticErrorRecovery: return OnRecovery(situation);
    case Ask::kPressUserStop: return OnPressUserStop(situation);
    case Ask::kReleaseUserStop: return OnReleaseUserStop(situation);
    case Ask::kCloseBrakes: return OnCloseBrakes(situation);
    case Ask::kOpenBrakes: return OnOpenBrakes(situation);
    case Ask::kPressGuidingButton: return OnPressGuiding(situation);
    case Ask::kReleaseGuidingButton: return OnReleaseGuiding(situation);
  }
  return {};
}

}  // namespace twin::test
