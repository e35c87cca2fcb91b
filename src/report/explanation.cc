#include "twin/report/explanation.h"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "report/abort_page.h"
#include "report/loss_facts.h"
#include "report/paragraphs.h"
#include "report/plan_facts.h"
#include "report/run_end.h"
#include "report/worked_value.h"
#include "twin/core/error.h"
#include "twin/core/error_catalogue.h"
#include "twin/core/time.h"
#include "twin/report/logged_motions.h"

namespace twin::report {
namespace {

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
    return fmt::format("{:.6g} {}; {:.6g} end a motion", v.value, entry.quantity, v.limit);
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
    text += DescribeMotion(before.motion_generator_mode, before.controller_mode);
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

void AddText(ToldAbort& story, std::string label, std::string text) {
  if (!text.empty()) story.paragraphs.push_back({std::move(label), {std::move(text)}});
}

/// Errors that the command chain's generator, filter or limiter can keep off.
bool IsOfChain(RobotError error) {
  switch (error) {
    case RobotError::kJointMotionGeneratorVelocityDiscontinuity:
    case RobotError::kCartesianMotionGeneratorVelocityDiscontinuity:
    case RobotError::kJointMotionGeneratorAccelerationDiscontinuity:
    case RobotError::kCartesianMotionGeneratorAccelerationDiscontinuity:
    case RobotError::kControllerTorqueDiscontinuity: return true;
    default: return false;
  }
}

/// Errors that contacts cause.
bool IsReflex(RobotError error) {
  return error == RobotError::kJointReflex || error == RobotError::kCartesianReflex ||
         error == RobotError::kTauJRangeViolation;
}

/// Whether a force acted in the cycles before the abort.
bool Acted(const ScriptedForce& force, const RunEnd& end) {
  if (force.motion && *force.motion != end.number) return false;
  const double since = force.motion ? end.begin : 0;
  const double now = ToSeconds(end.last().at.time_since_epoch()) - since;
  return force.begin <= now && now <= force.end + RunEnd::kShown * kCycleSeconds;
}

std::string TellContacts(const RunEnd& end, const Violation& v,
                         const std::optional<ScenarioFacts>& facts) {
  std::string text;
  if (end.contacts == "none") {
    if (IsReflex(v.error)) text = "The simulated arm touched nothing in the 50 cycles before.";
  } else if (!end.contacts.empty()) {
    text = end.contacts + ".";
  }
  if (!IsReflex(v.error) || !facts) return text;
  for (const ScriptedForce& force : facts->forces) {
    if (!Acted(force, end)) continue;
    text += fmt::format(
        "{}The scenario {} from {:.3f} s to {:.3f} s{} (perturbations): the robot takes it for a "
        "contact.",
        text.empty() ? "" : " ", force.what, force.begin, force.end,
        force.motion ? " of the motion" : "");
  }
  return text;
}

/// Joints that the mechanical end of their range holds.
std::string TellEndStops(const RunEnd& end, const Violation& v) {
  constexpr double kAtStop = 1e-3;  // rad
  if (!end.run.limits) return "";
  const JointLimits& limits = end.run.limits->joints;
  std::string text;
  for (std::size_t i = 0; i < kJoints; ++i) {
    const double q = end.last().state.q[i];
    const double above = q - limits.q_max[i];
    const double below = limits.q_min[i] - q;
    const bool is_upper = above > below;
    const double beyond = std::max(above, below);
    if (!(beyond > -kAtStop)) continue;
    text += fmt::format(
        "{}joint {} is at its {} end stop: q = {:.4f} rad, {:.2g} mrad {} {:.4f} rad",
        text.empty() ? "" : "; ", i + 1, is_upper ? "upper" : "lower", q, std::abs(beyond) * 1e3,
        beyond > 0 ? "beyond" : "short of", is_upper ? limits.q_max[i] : limits.q_min[i]);
  }
  if (text.empty()) return "";
  return text + (IsReflex(v.error)
                     ? ". The stop pushes the joint back, and the robot takes that for an external "
                       "force. Keep the motion away from the ends of the joints' ranges."
                     : ".");
}

/// A scenario's keys help only where the log's own workstation formed the commands; in a server's
/// log a client's program did.
std::string TellRemedy(const RunEnd& end, const Violation& v,
                       const std::optional<ScenarioFacts>& facts) {
  const ErrorEntry& entry = EntryOf(v);
  if (entry.cure.empty()) return "";
  if (!end.has_ticks) return fmt::format("{}.", entry.cure);
  if (facts && IsOfChain(v.error)) {
    return RemedyIn(*facts, v, KeeperOf(end), AnyHeld(end)) + ".";
  }
  return RemedyOfDeviation(end, facts) + CureOf(entry, KeeperOf(end)) + ".";
}

ToldAbort TellAbort(const RunEnd& end, const std::optional<ScenarioFacts>& facts) {
  const record::CycleRecord& last = end.last();
  const Violation v = ErrorOf(last);
  const ErrorEntry& entry = EntryOf(v);
  ToldAbort story{.end = &end, .headline = {}, .paragraphs = {}};
  story.headline = fmt::format("{}: aborted at {:.3f} s by {}", end.run.scenario,
                               ToSeconds(last.at.time_since_epoch()), Name(v.error));
  Paragraph what{"what", {fmt::format("{}.", entry.meaning)}};
  for (std::string& line : OtherErrors(last, v.error)) what.lines.push_back(std::move(line));
  story.paragraphs.push_back(std::move(what));
  AddText(story, "where", WhereText(end, v) + ".");
  if (last.violated) {
    AddText(story, "value", (end.guard.empty() ? ValueText(v, entry) : end.guard) + ".");
    Paragraph computed{"computed", {fmt::format("{}.", entry.computed)}};
    for (std::string& line : WorkOut(end)) computed.lines.push_back(std::move(line));
    story.paragraphs.push_back(std::move(computed));
  } else {
    AddText(story, "value",
            end.is_remote() ? "not known: the robot tells the names of its errors, but neither "
                              "joint nor value nor limit."
                            : "the log does not tell which value broke which limit.");
  }
  AddText(story, "end stop", TellEndStops(end, v));
  AddText(story, "touching", TellContacts(end, v, facts));
  AddText(story, "commands", CountFates(end));
  AddText(story, "lost before", JudgeLosses(end));
  AddText(story, "torques", TellRepeatedTorque(end));
  AddText(story, "workstation", CountTicks(end));
  AddText(story, "kept back", TellKeptBack(end));
  AddText(story, "deviation", TellDeviation(end));
  if (last.violated && facts) AddText(story, "injected", TellNoise(end, v, *facts));
  AddText(story, "usual cause", fmt::format("{}.", entry.cause));
  AddText(story, "what to do", TellRemedy(end, v, facts));
  if (end.truncated) {
    AddText(story, "note", "The run was killed later on: the end of its log is missing.");
  }
  return story;
}

std::string HowItEnded(const RunEnd& end) {
  if (end.user_stopped) {
    return fmt::format("the user stop was pressed at {:.3f} s", *end.user_stopped);
  }
  if (!end.moved) return "no motion ran";
  if (end.last_word.empty() || end.last_word == "finished") return "no error";
  if (end.last_word.starts_with("started"))
    return "no error of the robot; the log ends in the motion";
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

/// "1, 2 and 5": the motions that errors ended, or after which errors were raised.
std::string NumbersOf(const std::vector<RunEnd>& ends) {
  std::vector<std::uint64_t> numbers;
  for (const RunEnd& end : ends) {
    if (numbers.empty() || numbers.back() != end.number) numbers.push_back(end.number);
  }
  if (numbers.size() == 1) return fmt::format("{}", numbers.front());
  const std::uint64_t last = numbers.back();
  numbers.pop_back();
  return fmt::format("{} and {}", fmt::join(numbers, ", "), last);
}

ExplainedError ExplainedErrorOf(const RunEnd& end) {
  return {.violation = ErrorOf(end.last()),
          .has_value = end.last().violated,
          .cycle = end.last().state.message_id,
          .at = end.last().at,
          .motion = end.number};
}

/// "; motion 2 ended otherwise: stopped"; empty where the log does not tell.
std::string HowMotionEnded(const std::filesystem::path& log, std::uint64_t number) {
  const std::vector<LoggedMotion> motions = ReadSession(log).motions;
  if (number == 0 || number > motions.size()) return "";
  return fmt::format("; motion {} ended otherwise: {}", number, motions[number - 1].how);
}

/// Text and page of a log with aborts.
Explanation TellAborts(const std::filesystem::path& log, const std::vector<RunEnd>& ends,
                       const std::optional<ScenarioFacts>& facts,
                       std::optional<std::uint64_t> motion, ExplanationParts parts) {
  const bool draws_page = parts == ExplanationParts::kTextAndPage;
  const std::uint64_t number = motion.value_or(ends.front().number);
  Explanation told{.aborted = true, .text = {}, .page = {}};
  std::vector<ToldAbort> on_page;
  for (const RunEnd& end : ends) {
    const bool is_chosen = motion ? end.number == number : &end == &ends.front();
    if (!is_chosen && on_page.size() >= Explanation::kMostOnPage) continue;
    ToldAbort story = TellAbort(end, facts);
    if (is_chosen && !told.error) told.error = ExplainedErrorOf(end);
    if (is_chosen) told.text += story.headline + "\n" + ToText(story.paragraphs);
    on_page.push_back(std::move(story));
  }
  if (told.text.empty()) {
    throw InputError(fmt::format("no error ended motion {} of {}; errors ended motion {}{}", number,
                                 ends.front().run.scenario, NumbersOf(ends),
                                 HowMotionEnded(log, number)));
  }
  if (ends.size() == 1) {
    if (draws_page) told.page = AbortPage(on_page, on_page.front().headline, "");
    return told;
  }
  const bool has_all = on_page.size() == ends.size();
  told.text += ToText(
      {{"note",
        {fmt::format("This log has {} errors, in motions {}; this is about motion {}. --motion N "
                     "picks another; the page has {}.",
                     ends.size(), NumbersOf(ends), number,
                     has_all ? "all" : fmt::format("{} of them", on_page.size()))}}});
  if (!draws_page) return told;
  const std::string rest =
      has_all ? ""
              : fmt::format(
                    "These are {} of {} errors, in motions {}: panda-twin explain --motion N "
                    "tells the others.",
                    on_page.size(), ends.size(), NumbersOf(ends));
  told.page = AbortPage(on_page,
                        fmt::format("{}: {} errors", ends.front().run.scenario, ends.size()), rest);
  return told;
}

}  // namespace

std::string RemedyIn(const ScenarioFacts& facts, const Violation& violation, TimeKeeper keeper,
                     bool any_lost) {
  const ErrorEntry& entry = EntryOf(violation);
  if (violation.error == RobotError::kControllerTorqueDiscontinuity) {
    return fmt::format("begin at the state's tau_J_d, or lower the controller's gains{}",
                       facts.has_limiter ? "" : "; tick.limiter: true limits the torque's rate");
  }
  if (!IsOfChain(violation.error)) return std::string(CureHere(entry, keeper));
  std::vector<std::string_view> ways;
  if (!facts.has_default_generator && !facts.has_viability) {
    ways.emplace_back(
        "leave tick.generator and tick.viability out: their defaults resample the targets and "
        "keep the limits");
    if (facts.has_generator) ways.emplace_back("or say tick.viability: 19 behind this generator");
    if (!facts.has_limiter) ways.emplace_back("or say tick.limiter: true");
  } else if (!facts.has_viability) {
    ways.emplace_back("leave tick.viability out: its default keeps the limits");
  } else if (!facts.has_default_generator) {
    ways.emplace_back("leave tick.generator out: its default resamples the targets");
  }
  if (any_lost && keeper == TimeKeeper::kVirtualClock)
    ways.emplace_back("lose fewer messages (link)");
  if (keeper == TimeKeeper::kWallClock) {
    ways.emplace_back(
        "see how well this host keeps time (panda-twin check): threads that run late make uneven "
        "commands");
  }
  ways.emplace_back("move more gently");
  return fmt::format("{}", fmt::join(ways, "; "));
}

Explanation Explain(const std::filesystem::path& log, const std::optional<ScenarioFacts>& facts,
                    std::optional<std::uint64_t> motion, ExplanationParts parts) {
  std::vector<RunEnd> ends = ReadEnds(log);
  const RunEnd& end = ends.front();
  if (end.aborted()) {
    const bool is_linked = facts && facts->link && !end.is_remote();
    for (RunEnd& abort : ends) {
      if (is_linked) AddLinkFates(abort, *facts->link);
    }
    return TellAborts(log, ends, facts, motion, parts);
  }
  if (end.truncated) {
    throw InputError(fmt::format(
        "{} ends at {:.3f} s, where its run was killed, without an error before: how the run ended "
        "is not in it",
        log.string(), end.end));
  }
  if (motion) {
    throw InputError(
        fmt::format("no error ended motion {} of {}: the log has none{}; leave --motion out",
                    *motion, log.string(), HowMotionEnded(log, *motion)));
  }
  return {.aborted = false,
          .text = fmt::format("{}: {}; the log ends at {:.3f} s\n{}{}", end.run.scenario,
                              HowItEnded(end), end.end,
                              end.last_word == "finished" ? "" : ToText(TellHindrances(end, facts)),
                              TellApproach(end)),
          .page = ""};
}

}  // namespace twin::report
