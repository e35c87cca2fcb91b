#include "twin/report/explanation.h"

#include <cmath>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "report/abort_page.h"
#include "report/loss_facts.h"
#include "report/paragraphs.h"
#include "report/run_end.h"
#include "report/worked_value.h"
#include "twin/core/error.h"
#include "twin/core/error_catalogue.h"
#include "twin/core/time.h"

namespace twin::report {
namespace {

/// Content of an explanation.
struct Story {
  std::string headline;
  std::vector<Paragraph> paragraphs;
};

/// The error to explain: that with a known value, else the first.
Violation ErrorOf(const record::CycleRecord& cycle) {
  if (cycle.violated) return cycle.violation;
  std::size_t first = 0;
  while (!cycle.state.errors[first]) ++first;
  return {.error = static_cast<RobotError>(first)};
}

/// On the robot's time no thread can be late: the robot's own clock or link caused the losses.
TimeKeeper KeeperOf(const RunEnd& end) {
  const bool is_virtual = end.run.drive == "lockstep" || end.on_robot_time;
  return is_virtual ? TimeKeeper::kVirtualClock : TimeKeeper::kWallClock;
}

/// Value and limit of a violation, and by how much the value exceeds the limit.
std::string ValueText(const Violation& v, const ErrorEntry& entry) {
  if (v.error == RobotError::kCommunicationConstraintsViolation) {
    return fmt::format("{:.6g} {}; it may be at most {:.6g}", v.value, entry.quantity, v.limit - 1);
  }
  const std::string unit = UnitOf(v).empty() ? "" : fmt::format(" {}", UnitOf(v));
  std::string text = fmt::format("{} {:.7g}{}; the limit is {:.7g}{}", entry.quantity, v.value,
                                 unit, v.limit, unit);
  const bool is_place = unit == " rad" || unit == " m" || unit.empty();
  if (!std::isfinite(v.value) || v.limit == 0) return text;
  if (is_place) return text + fmt::format(", {:.3g}{} away", std::abs(v.value - v.limit), unit);
  const double share = std::abs(v.value / v.limit);
  return text + (share < 2 ? fmt::format(", exceeded by {:.3g} %", 100 * (share - 1))
                           : fmt::format("; it is {:.3g} times that", share));
}

std::string WhereText(const RunEnd& end, const Violation& v) {
  const RobotState& before = end.before().state;
  const std::string axis = AxisName(v);
  std::string text = axis.empty() ? "" : axis + "; ";
  if (before.motion_generator_mode == MotionGeneratorMode::kIdle) {
    text += "no motion was running";
  } else {
    text += fmt::format("{} motion under {}", Name(before.motion_generator_mode),
                        Name(before.controller_mode));
  }
  if (!end.motion.empty()) text += "; in " + end.motion;
  return text + fmt::format("; cycle of state {}, {:.3f} s", end.last().state.message_id,
                            ToSeconds(end.last().at.time_since_epoch()));
}

std::vector<std::string> OtherErrors(const record::CycleRecord& cycle, RobotError told) {
  std::vector<std::string> lines;
  for (std::size_t i = 0; i < kRobotErrorCount; ++i) {
    const auto error = static_cast<RobotError>(i);
    if (!cycle.state.errors[i] || error == told) continue;
    lines.push_back(fmt::format("In the same cycle: {}. {}.", Name(error), EntryOf(error).meaning));
  }
  return lines;
}

void AddText(Story& story, std::string label, std::string text) {
  if (!text.empty()) story.paragraphs.push_back({std::move(label), {std::move(text)}});
}

void AddNotes(Story& story, const RunEnd& end) {
  if (end.aborts > 1) {
    AddText(
        story, "note",
        fmt::format("An error ended {} motions of this log; this is about the first.", end.aborts));
  }
  if (end.truncated) {
    AddText(story, "note", "The run was killed later on: the end of its log is missing.");
  }
}

/// Derivative of positions or torques that an error limits; 0: none.
int OrderOf(RobotError error) {
  switch (error) {
    case RobotError::kJointMotionGeneratorVelocityLimitsViolation:
    case RobotError::kCartesianMotionGeneratorVelocityLimitsViolation:
    case RobotError::kControllerTorqueDiscontinuity: return 1;
    case RobotError::kJointMotionGeneratorVelocityDiscontinuity:
    case RobotError::kCartesianMotionGeneratorVelocityDiscontinuity: return 2;
    case RobotError::kJointMotionGeneratorAccelerationDiscontinuity:
    case RobotError::kCartesianMotionGeneratorAccelerationDiscontinuity: return 3;
    default: return 0;
  }
}

/// Empty when the noise alone cannot break the limit.
std::string TellNoise(const RunEnd& end, const Violation& v, const Injected& injected) {
  const MotionGeneratorMode mode = end.before().state.motion_generator_mode;
  const bool by_velocity = mode == MotionGeneratorMode::kJointVelocity ||
                           mode == MotionGeneratorMode::kCartesianVelocity;
  const bool by_torque = v.error == RobotError::kControllerTorqueDiscontinuity;
  const int order = OrderOf(v.error) - (by_velocity && !by_torque ? 1 : 0);
  if (injected.is_smoothed || order <= 0) return "";
  // A difference of two values is at most twice the largest.
  const double most = injected.target_noise * std::pow(2 / kCycleSeconds, order);
  if (!(most > v.limit)) return "";
  return fmt::format(
      "the scenario adds noise of up to {:.3g} to every target (controller.target_noise), and no "
      "reference generator smooths it: the noise alone makes up to {:.3g} {}. Take it out, or "
      "choose a generator (tick.generator).",
      injected.target_noise, most, UnitOf(v));
}

Story TellAbort(const RunEnd& end, const Injected& injected) {
  const record::CycleRecord& last = end.last();
  const Violation v = ErrorOf(last);
  const ErrorEntry& entry = EntryOf(v);
  Story story;
  story.headline = fmt::format("{}: aborted at {:.3f} s by {}", end.run.scenario,
                               ToSeconds(last.at.time_since_epoch()), Name(v.error));
  Paragraph what{"what", {fmt::format("{}.", entry.meaning)}};
  for (std::string& line : OtherErrors(last, v.error)) what.lines.push_back(std::move(line));
  story.paragraphs.push_back(std::move(what));
  AddText(story, "where", WhereText(end, v) + ".");
  if (last.violated) {
    AddText(story, "value", ValueText(v, entry) + ".");
    Paragraph computed{"computed", {fmt::format("{}.", entry.computed)}};
    for (std::string& line : WorkOut(end)) computed.lines.push_back(std::move(line));
    story.paragraphs.push_back(std::move(computed));
  } else {
    AddText(story, "value",
            end.is_remote() ? "not known: the robot tells the names of its errors, but neither "
                              "joint nor value nor limit."
                            : "the log does not tell which value broke which limit.");
  }
  AddText(story, "commands", CountFates(end));
  AddText(story, "lost before", JudgeLosses(end));
  AddText(story, "workstation", CountTicks(end));
  if (last.violated) AddText(story, "injected", TellNoise(end, v, injected));
  AddText(story, "usual cause", fmt::format("{}.", entry.cause));
  AddText(story, "what to do", entry.cure.empty() ? "" : CureOf(entry, KeeperOf(end)) + ".");
  AddNotes(story, end);
  return story;
}

std::string HowItEnded(const RunEnd& end) {
  if (end.user_stopped) {
    return fmt::format("the user stop was pressed at {:.3f} s", *end.user_stopped);
  }
  if (!end.moved) return "no motion ran";
  if (end.last_word.empty() || end.last_word == "finished") return "no error";
  return fmt::format("no error of the robot; the motion ended early: {}", end.last_word);
}

std::string TellApproach(const RunEnd& end) {
  std::string text = "how close it came to the limits\n";
  for (const Approach& approach : end.approach.Closest()) {
    text += fmt::format("  {:<34} {:>5.1f} %  {}\n", approach.what, 100 * approach.share,
                        PlaceOf(approach));
  }
  if (!end.approach.has_limits()) {
    text += "  this log does not hold the robot's limits: an earlier version wrote it\n";
  }
  text += end.fates_unknown()
              ? fmt::format("  {:<34} not known at this end of the wire\n", "commands lost")
              : fmt::format("  {:<34} {:>5}    FCI ends a motion after 20\n",
                            "most commands lost in a row", end.approach.longest_loss());
  text += fmt::format("  {:<34} {:>5.1f}    Nm, largest of the joints, estimated\n",
                      "external torque", end.approach.peak_torque());
  text += fmt::format("  {:<34} {:>5.1f}    N on the end effector, estimated\n", "external force",
                      end.approach.peak_force());
  return text;
}

}  // namespace

Explanation Explain(const std::filesystem::path& log, const Injected& injected) {
  const RunEnd end = ReadEnd(log);
  if (end.aborted()) {
    const Story story = TellAbort(end, injected);
    return {.aborted = true,
            .text = story.headline + "\n" + ToText(story.paragraphs),
            .page = AbortPage(end, story.headline, story.paragraphs)};
  }
  if (end.truncated) {
    throw InputError(fmt::format(
        "{} ends at {:.3f} s, where its run was killed, without an error before: how the run ended "
        "is not in it",
        log.string(), end.end));
  }
  return {.aborted = false,
          .text = fmt::format("{}: {}; the log ends at {:.3f} s\n{}", end.run.scenario,
                              HowItEnded(end), end.end, TellApproach(end)),
          .page = ""};
}

}  // namespace twin::report
