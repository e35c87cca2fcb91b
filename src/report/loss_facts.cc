#include "report/loss_facts.h"

#include <algorithm>
#include <array>
#include <vector>

#include <fmt/format.h>

#include "twin/core/time.h"
#include "twin/faults/message_fate.h"

namespace twin::report {
namespace {

/// "1 command", "3 commands".
std::string Count(std::uint64_t count, std::string_view one) {
  return fmt::format("{} {}{}", count, one, count == 1 ? "" : "s");
}

/// True for errors that a command raises when it must close the gap left by lost commands.
bool ComesFromAGap(RobotError error) {
  switch (error) {
    case RobotError::kJointMotionGeneratorVelocityLimitsViolation:
    case RobotError::kJointMotionGeneratorVelocityDiscontinuity:
    case RobotError::kJointMotionGeneratorAccelerationDiscontinuity:
    case RobotError::kCartesianMotionGeneratorVelocityLimitsViolation:
    case RobotError::kCartesianMotionGeneratorVelocityDiscontinuity:
    case RobotError::kCartesianMotionGeneratorAccelerationDiscontinuity:
    case RobotError::kCartesianMotionGeneratorJointVelocityLimitsViolation:
    case RobotError::kCartesianMotionGeneratorJointVelocityDiscontinuity:
    case RobotError::kCartesianMotionGeneratorJointAccelerationDiscontinuity:
    case RobotError::kControllerTorqueDiscontinuity: return true;
    default: return false;
  }
}

bool IsHeld(const EndCycle& cycle) {
  return cycle.cycle.fate == record::CommandFate::kHeld;
}

/// Index of the first shown cycle.
std::size_t FirstShown(const RunEnd& end) {
  return end.cycles.size() > RunEnd::kShown ? 1 : 0;
}

std::size_t HeldShown(const RunEnd& end) {
  return static_cast<std::size_t>(std::count_if(
      end.cycles.begin() + static_cast<std::ptrdiff_t>(FirstShown(end)), end.cycles.end(), IsHeld));
}

/// Text for a loss immediately before a refused command.
std::string JudgeResume(const RunEnd& end, std::uint32_t lost) {
  if (end.last().violation.error == RobotError::kControllerTorqueDiscontinuity) {
    return fmt::format(
        "Likely: it is the first command after {} lost ones in a row. The robot held the last "
        "torque, the controller's went on; this command had to make up for {} cycles at once.",
        lost, lost + 1);
  }
  const std::uint32_t factor = (lost + 1) * (lost + 2) / 2;
  return fmt::format(
      "Likely: it is the first command after {} in a row that did not come. The robot held the "
      "last "
      "acceleration, the source went on by its own; closing that gap in one cycle takes about {} "
      "times the jerk of the motion itself, (n + 1)(n + 2) / 2 with n = {}.",
      lost, factor, lost);
}

/// Length of the last loss before the last cycle, and the cycles since its end; {0, 0}: no loss.
std::pair<std::uint32_t, std::size_t> LastLoss(const RunEnd& end) {
  for (std::size_t ago = 1; ago < end.cycles.size(); ++ago) {
    const EndCycle& cycle = end.cycles[end.cycles.size() - 1 - ago];
    if (IsHeld(cycle)) return {cycle.cycle.lost_in_row, ago};
  }
  return {0, 0};
}

/// Why a held cycle had no command.
enum class HeldCause : std::uint8_t { kStateLost, kSilent, kUnwritten, kLost, kLate, kUnknown };

HeldCause CauseOf(const EndCycle& cycle) {
  if (!cycle.answer) {
    return cycle.link && cycle.link->state_lost ? HeldCause::kStateLost : HeldCause::kSilent;
  }
  if (!cycle.written()) return HeldCause::kUnwritten;
  if (!cycle.link) return HeldCause::kUnknown;
  if (cycle.link->command_lost) return HeldCause::kLost;
  return cycle.link->late > Duration::zero() ? HeldCause::kLate : HeldCause::kUnknown;
}

std::string LateText(Duration late) {
  return fmt::format("{:.3g} ms", ToSeconds(late) * 1e3);
}

/// Reasons of the shown held cycles, with their numbers. @pre end.has_ticks.
std::vector<std::string> CausesOfHeld(const RunEnd& end, bool any_dropped) {
  std::array<std::uint64_t, 6> counts{};
  Duration latest{};
  for (std::size_t i = FirstShown(end); i < end.cycles.size(); ++i) {
    const EndCycle& cycle = end.cycles[i];
    if (!IsHeld(cycle)) continue;
    const HeldCause cause = CauseOf(cycle);
    ++counts[static_cast<std::size_t>(cause)];
    if (cause == HeldCause::kLate) latest = std::max(latest, *cycle.link->late);
  }
  const auto [state_lost, silent, unwritten, lost, late, unknown] = counts;
  std::vector<std::string> causes;
  if (state_lost > 0) {
    causes.push_back(fmt::format("{} because the link lost the state before it", state_lost));
  }
  if (silent > 0) {
    causes.push_back(fmt::format(
        "{} because the workstation did not see the state before it, or did not run", silent));
  }
  if (unwritten > 0) {
    causes.push_back(
        fmt::format("{} because the workstation saw the state, but wrote nothing", unwritten));
  }
  if (lost > 0) causes.push_back(fmt::format("{} because the link lost the command", lost));
  if (late > 0) {
    causes.push_back(fmt::format("{} because the command came too late, by {}{}", late,
                                 late > 1 ? "up to " : "", LateText(latest)));
  }
  if (unknown > 0) {
    causes.push_back(
        fmt::format("{} although the workstation wrote a command: it {}was lost on its way",
                    unknown, any_dropped ? "came too late or " : ""));
  }
  return causes;
}

/// For a log of the robot's side. Empty if the link lost nothing that is known.
std::string CountLinkLosses(const RunEnd& end) {
  std::uint64_t lost = 0;
  for (std::size_t i = FirstShown(end); i < end.cycles.size(); ++i) {
    const EndCycle& cycle = end.cycles[i];
    if (!IsHeld(cycle) || !cycle.link) continue;
    lost += cycle.link->state_lost || cycle.link->command_lost;
  }
  return lost == 0 ? ""
                   : fmt::format(
                         " Of those held, {} because the link lost the state before it or "
                         "the command.",
                         lost);
}

}  // namespace

void AddLinkFates(RunEnd& end, const LinkFacts& link) {
  faults::MessageFate states(link.state, link.seed, faults::kStateStreams);
  faults::MessageFate commands(link.command, link.seed, faults::kCommandStreams);
  for (EndCycle& cycle : end.cycles) {
    const std::uint64_t answered = cycle.cycle.state.message_id - 1;
    const faults::Fate command = commands.Of(answered);
    cycle.link = {.state_lost = states.Of(answered).lost, .command_lost = command.lost};
    if (!cycle.written() || command.lost) continue;
    cycle.link->late = cycle.answer->written + command.delay - (cycle.cycle.at - link.d_INT);
  }
}

std::string WhyHeld(const EndCycle& cycle) {
  switch (CauseOf(cycle)) {
    case HeldCause::kStateLost: return "state lost";
    case HeldCause::kSilent: return "no answer";
    case HeldCause::kUnwritten: return "not written";
    case HeldCause::kLost: return "lost";
    case HeldCause::kLate: return LateText(*cycle.link->late) + " late";
    case HeldCause::kUnknown: break;
  }
  return "";
}

bool AnyHeld(const RunEnd& end) {
  return HeldShown(end) > 0;
}

std::string TellRepeatedTorque(const RunEnd& end) {
  constexpr std::size_t kNotable = 5;  // cycles; a controller at 200 Hz repeats as many
  std::size_t most = 0;
  std::size_t ended = 0;  // cycle after the longest
  std::size_t row = 1;
  for (std::size_t i = 1; i < end.cycles.size(); ++i) {
    const record::CycleRecord& now = end.cycles[i].cycle;
    const bool repeats = now.state.controller_mode == ControllerMode::kExternalController &&
                         now.fate != record::CommandFate::kHeld &&
                         now.state.tau_J_d != JointVector{} &&
                         now.state.tau_J_d == end.cycles[i - 1].cycle.state.tau_J_d;
    row = repeats ? row + 1 : 1;
    if (row <= most) continue;
    most = row;
    ended = i + 1;
  }
  if (most <= kNotable) return "";
  const std::size_t ago = end.cycles.size() - ended;
  return fmt::format(
      "The same torque was commanded for {} in a row, until {}. The controller did not compute "
      "meanwhile, and the arm moved on as that torque, which was right for one instant, drove it. "
      "Let the controller compute a torque for each state.",
      Count(most, "cycle"),
      ago == 0 ? "the error" : fmt::format("{} before the error", Count(ago, "cycle")));
}

std::string JudgeLosses(const RunEnd& end) {
  if (end.fates_unknown()) return "";
  const record::CycleRecord& last = end.last();
  const bool is_loss =
      last.violated && last.violation.error == RobotError::kCommunicationConstraintsViolation;
  if (is_loss) return "";  // the error itself says so
  if (last.fate == record::CommandFate::kHeld) {
    return fmt::format(
        "Yes: this cycle had no command, the {}th in a row. The robot went on by the acceleration "
        "of the last one, and that led over the limit.",
        last.lost_in_row);
  }
  const auto [lost, ago] = LastLoss(end);
  if (lost == 0) {
    return fmt::format("No: every one of the {} before had its command, or needed none.",
                       Count(end.cycles.size() - 1, "cycle"));
  }
  const bool from_gap = last.violated && ComesFromAGap(last.violation.error);
  if (from_gap && ago == 1) return JudgeResume(end, lost);
  // A source with feedback from the state (a controller, a filter) settles after a gap.
  constexpr std::size_t kSettling = 10;
  if (from_gap && ago <= kSettling) {
    return fmt::format(
        "Possible: {} in a row were lost up to {} before. A command right after a gap was "
        "accepted, but what follows it (a controller or filter that settles) can still break a "
        "limit.",
        Count(lost, "command"), Count(ago, "cycle"));
  }
  return fmt::format("Unlikely: {} held in the last {}, the last one {} before this cycle.",
                     Count(HeldShown(end), "cycle"), end.cycles.size() - FirstShown(end),
                     Count(ago, "cycle"));
}

std::string CountFates(const RunEnd& end) {
  if (end.fates_unknown()) {
    return "what became of them is not known at this end of the wire; the log of the robot's side "
           "(panda-twin serve --log) has it.";
  }
  std::uint64_t served = 0, held = 0, none = 0, dropped = 0;
  for (std::size_t i = FirstShown(end); i < end.cycles.size(); ++i) {
    const EndCycle& cycle = end.cycles[i];
    served += cycle.cycle.fate == record::CommandFate::kServed;
    held += IsHeld(cycle);
    none += cycle.cycle.fate == record::CommandFate::kNone;
    dropped += cycle.cycle.dropped;
  }
  std::string text =
      fmt::format("{} served, {} held, {} in which none was due or the first was awaited.",
                  Count(served, "cycle"), held, none);
  if (dropped > 0) {
    text += fmt::format(" {} came, but too late, doubled or with a wrong id.",
                        Count(dropped, "command"));
  }
  if (held == 0) return text;
  if (!end.has_ticks) {
    return text + CountLinkLosses(end) +
           " What the client wrote is not in this log, which is of the robot's side.";
  }
  return text + fmt::format(" Of those held, {}.", fmt::join(CausesOfHeld(end, dropped > 0), "; "));
}

std::string CountTicks(const RunEnd& end) {
  std::uint64_t skipped = 0, invalid = 0, reused = 0, written = 0;
  std::optional<Time> deposit;
  for (const EndCycle& cycle : end.cycles) {
    if (!cycle.answer) continue;
    const record::TickRecord& tick = *cycle.answer;
    skipped += tick.action == record::TickAction::kSkipped;
    invalid += tick.action == record::TickAction::kInvalid;
    if (tick.action != record::TickAction::kWritten) continue;
    ++written;
    reused += deposit == tick.deposit_time;
    deposit = tick.deposit_time;
  }
  std::vector<std::string> facts;
  if (skipped > 0) {
    facts.push_back(
        fmt::format("left {} unanswered, because they came out of time", Count(skipped, "state")));
  }
  if (invalid > 0) {
    facts.push_back(fmt::format("wrote nothing for {}, because the controller gave no valid one",
                                Count(invalid, "state")));
  }
  if (reused > 0) {
    facts.push_back(
        fmt::format("formed {} of {} from a target that it had used before, the source "
                    "having deposited no new one",
                    reused, Count(written, "command")));
  }
  return facts.empty() ? "" : fmt::format("The workstation {}.", fmt::join(facts, "; it "));
}

}  // namespace twin::report
