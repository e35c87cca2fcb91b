#include "twin/run/summary.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "twin/core/error_catalogue.h"
#include "twin/core/hash.h"
#include "twin/plant/perturbation.h"

namespace twin::run {
namespace {

using Json = nlohmann::ordered_json;

Json PercentilesUs(const rt::DurationHistogram& histogram) {
  return {{"count", histogram.count()},
          {"p50", ToMicroseconds(histogram.Percentile(0.5))},
          {"p99", ToMicroseconds(histogram.Percentile(0.99))},
          {"p99.9", ToMicroseconds(histogram.Percentile(0.999))},
          {"max", ToMicroseconds(histogram.max())}};
}

std::string PercentilesText(const rt::DurationHistogram& histogram) {
  return fmt::format("{:.1f} / {:.1f} / {:.1f} us (median, p99, max)",
                     ToMicroseconds(histogram.Percentile(0.5)),
                     ToMicroseconds(histogram.Percentile(0.99)), ToMicroseconds(histogram.max()));
}

/// What helps against the errors that ended the run, each text once.
std::vector<std::string> CuresOf(const scenario::Scenario& scenario, const RunResult& result) {
  const TimeKeeper keeper =
      scenario.is_lockstep() ? TimeKeeper::kVirtualClock : TimeKeeper::kWallClock;
  std::vector<std::string> cures;
  const report::ScenarioFacts facts = FactsOf(scenario);
  const auto add = [&](const Violation& violation) {
    std::string cure = report::RemedyIn(facts, violation, keeper, result.counts.held > 0);
    if (std::ranges::find(cures, cure) == cures.end()) cures.push_back(std::move(cure));
  };
  for (const Violation& violation : result.report.violations) add(violation);
  if (!result.report.violations.empty()) return cures;
  // A robot at the other end of a wire names its errors, and no more.
  for (std::size_t i = 0; i < kRobotErrorCount; ++i) {
    if (result.report.errors.test(i)) add({.error = static_cast<RobotError>(i)});
  }
  return cures;
}

Json SecondsOf(const std::optional<Time>& time) {
  return time ? Json(ToSeconds(time->time_since_epoch())) : Json();
}

/// Poses leave the joints where the null space took them: of their motions the pose counts.
std::string FinalErrorText(const RunResult& result) {
  std::string joints = fmt::format("{:.2e} rad, largest of the joints", result.final_error);
  const auto& pose = result.final_pose_error;
  if (!pose) return joints;
  return fmt::format("{:.2e} m and {:.2e} rad of the pose ({})", pose->distance, pose->angle,
                     joints);
}

/// "success", ...; of a command that has not ended, how far it came.
std::string_view ResultOf(const HandOutcome& outcome) {
  if (outcome.result) return Name(*outcome.result);
  return outcome.begun ? "running" : "not begun";
}

/// What the hand did; null when the scenario asks nothing of it.
Json HandJson(const scenario::Scenario& scenario, const RunResult& result) {
  if (!result.hand) return {};
  Json commands = Json::array();
  for (std::size_t i = 0; i < result.hand->commands.size(); ++i) {
    const HandOutcome& outcome = result.hand->commands[i];
    const bool ended = outcome.ended.has_value();
    commands.push_back({{"command", Name(scenario.hand[i].command)},
                        {"begun_s", SecondsOf(outcome.begun)},
                        {"ended_s", SecondsOf(outcome.ended)},
                        {"result", ResultOf(outcome)},
                        {"failure", outcome.failure},
                        {"width_m", ended ? Json(outcome.width) : Json()},
                        {"is_grasped", ended ? Json(outcome.is_grasped) : Json()}});
    if (outcome.pump) commands.back()["vacuum_mbar"] = outcome.pump->vacuum;
  }
  const HandState& state = result.hand->state;
  Json hand{{"commands", commands}, {"width_m", state.width}, {"is_grasped", state.is_grasped}};
  if (state.pump) hand["vacuum_mbar"] = state.pump->vacuum;
  return hand;
}

/// What planning took and gave; null when nothing was planned.
Json PlanJson(const RunResult& result) {
  if (!result.plan) return {};
  const planning::PlanStatistics& plan = *result.plan;
  return {{"checks", plan.checks},
          {"found_length_rad", plan.found_length},
          {"path_length_rad", plan.path_length},
          {"waypoints", plan.waypoints},
          {"duration_s", ToSeconds(plan.duration)}};
}

std::string PlanText(const planning::PlanStatistics& plan) {
  return fmt::format(
      "{:.3f} s through {} points, {:.2f} rad ({:.2f} as found); {} collision checks",
      ToSeconds(plan.duration), plan.waypoints, plan.path_length, plan.found_length, plan.checks);
}

std::string ContactsText(const plant::ContactWatch& contacts) {
  if (contacts.cycles() == 0) return "none";
  const plant::ContactPair first = contacts.Pairs().front();
  return fmt::format("in {} cycles; first {} and {}, at {:.3f} s", contacts.cycles(), first.a,
                     first.b, ToSeconds(first.first.time_since_epoch()));
}

std::string CyclesText(const CycleCounts& counts) {
  return fmt::format("{} served, {} held ({:.2f} %, at most {} in a row); {} commands dropped",
                     counts.served, counts.held, counts.unserved_percent(), counts.longest_loss,
                     counts.dropped);
}

std::string DeviationText(const loop::Deviation& deviation) {
  const auto seconds = [](Time at) { return ToSeconds(at.time_since_epoch()); };
  constexpr std::string_view kOfWhat = "arm from planned target, delay included";
  if (const auto& joints = deviation.joints) {
    return fmt::format("{:.2e} rad at most (joint {}, at {:.2f} s; rms {:.2e}), {}",
                       joints->largest, joints->joint + 1, seconds(joints->at), joints->rms,
                       kOfWhat);
  }
  if (const auto& pose = deviation.pose) {
    return fmt::format("{:.2e} m (at {:.2f} s) and {:.2e} rad (at {:.2f} s) at most, {}",
                       pose->position, seconds(pose->position_at), pose->angle,
                       seconds(pose->angle_at), kOfWhat);
  }
  return {};
}

/// Which commands were taken, a robot at the other end of a wire tells only as a share of the last
/// hundred, in its states.
std::string RemoteCyclesText(const loop::LoopTimings& timings) {
  return fmt::format(
      "{} commands written, {} states lost; the log's states hold the robot's "
      "control_command_success_rate",
      timings.written, timings.skipped_states);
}

/// Where its odometry has it; null when the arm stands on the world.
Json BaseJson(const RunResult& result) {
  if (!result.base) return {};
  const BasePose& at = result.base->odometry;
  return {{"x_m", at.x}, {"y_m", at.y}, {"yaw_rad", at.yaw}};
}

std::string BaseText(const BaseState& base) {
  return fmt::format(
      "{:.3f} m ahead, {:.3f} m to the left, {:.2f} rad of where it began, by its "
      "wheels",
      base.odometry.x, base.odometry.y, base.odometry.yaw);
}

std::string HandText(const scenario::Scenario& scenario, const HandReport& hand) {
  std::string text;
  for (std::size_t i = 0; i < hand.commands.size(); ++i) {
    text += fmt::format("{} {}, ", Name(scenario.hand[i].command), ResultOf(hand.commands[i]));
  }
  text += hand.state.pump ? fmt::format("{} mbar", hand.state.pump->vacuum)
                          : fmt::format("{:.1f} mm open", 1e3 * hand.state.width);
  return text + fmt::format(" at the end{}", hand.state.is_grasped ? ", something is grasped" : "");
}

std::vector<report::ScriptedForce> ForcesOf(const scenario::Scenario& scenario) {
  std::vector<report::ScriptedForce> forces;
  for (const plant::Perturbation& perturbation : scenario.perturbations) {
    const std::string& body = plant::BodyOf(perturbation);
    const auto add = [&](const auto& force, const std::string& what) {
      forces.push_back({.what = what,
                        .begin = ToSeconds(force.begin),
                        .end = ToSeconds(force.begin + force.duration),
                        .motion = force.motion});
    };
    if (const auto* push = std::get_if<plant::Push>(&perturbation)) {
      const Vector3& f = push->force;
      add(*push, fmt::format("pushes {} with {:.3g} N", body, std::hypot(f[0], f[1], f[2])));
    } else {
      const auto& spring = std::get<plant::HandSpring>(perturbation);
      add(spring,
          fmt::format("leads {} with a spring of up to {:.3g} N", body, spring.largest_force));
    }
  }
  return forces;
}

/// The first keys of summary.json.
Json HeadOf(const scenario::Scenario& scenario, std::string_view outcome,
            const std::string& failure) {
  return {{"scenario", scenario.name}, {"seed", scenario.seed}, {"drive", scenario.drive_name()},
          {"version", TWIN_VERSION},   {"outcome", outcome},    {"failure", failure}};
}

}  // namespace

std::string TextOf(const nlohmann::ordered_json& json) {
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

nlohmann::ordered_json DeviationJson(const FollowedMotion& motion) {
  const auto& [joints, pose] = motion.deviation;
  // A limit that is off is infinite, and has no number.
  const auto limit = [](double most) { return std::isfinite(most) ? Json(most) : Json(); };
  return {{"deviation_rad", joints ? Json(joints->largest) : Json()},
          {"deviation_m", pose ? Json(pose->position) : Json()},
          {"deviation_rotation_rad", pose ? Json(pose->angle) : Json()},
          {"max_deviation_rad", limit(motion.limit.joints)},
          {"max_deviation_m", limit(motion.limit.position)},
          {"max_deviation_rotation_rad", limit(motion.limit.angle)},
          {"deviation_exceeded", motion.exceeds()}};
}

nlohmann::ordered_json ContactsJson(const std::optional<plant::ContactWatch>& contacts) {
  if (!contacts) return {};
  Json pairs = Json::array();
  for (const plant::ContactPair& pair : contacts->Pairs()) {
    pairs.push_back({{"a", pair.a},
                     {"b", pair.b},
                     {"first_s", ToSeconds(pair.first.time_since_epoch())},
                     {"cycles", pair.cycles}});
  }
  return {{"cycles", contacts->cycles()}, {"pairs", pairs}};
}

nlohmann::ordered_json ViabilityJson(const std::optional<record::FilterCounts>& counts) {
  if (!counts) return {};
  const auto& nearest = counts->nearest;
  return {{"commands", counts->commands},
          {"kept_back", counts->kept_back},
          {"kept_back_of_joint", counts->of_joint},
          {"least_margin", nearest ? Json(nearest->margin) : Json()},
          {"least_margin_s", nearest ? Json(ToSeconds(nearest->at.time_since_epoch())) : Json()}};
}

std::string ViabilityText(const record::FilterCounts& counts) {
  std::string text = fmt::format("{} of {} commands ({:.2f} %)", counts.kept_back, counts.commands,
                                 counts.kept_back_percent());
  std::string_view separator = ": ";
  for (std::size_t i = 0; i < kJoints; ++i) {
    if (counts.of_joint[i] == 0) continue;
    text += fmt::format("{}joint {} in {}", separator, i + 1, counts.of_joint[i]);
    separator = ", ";
  }
  if (counts.nearest) {
    text += fmt::format("; least margin {:.3g}, at {:.3f} s", counts.nearest->margin,
                        ToSeconds(counts.nearest->at.time_since_epoch()));
  }
  return text;
}

report::ScenarioFacts FactsOf(const scenario::Scenario& scenario) {
  const robot::LinkConfig link = scenario::MakeLink(scenario.link);
  return {.target_noise = scenario.controller.target_noise,
          .has_generator = scenario.tick.generator != loop::Generator::kNone,
          .has_default_generator = scenario.tick.generator == scenario::TickSection().generator,
          .has_viability = scenario.tick.viability.has_value(),
          .has_limiter = scenario.tick.limiter,
          .forces = ForcesOf(scenario),
          .link = report::LinkFacts{scenario.seed, link.state, link.command, link.d_INT}};
}

std::string OutcomeOf(const RunResult& result, bool interrupted) {
  if (result.report.succeeded()) return "success";
  if (interrupted) return "interrupted";
  const bool aborted = result.report.end == backend::MotionEnd::kAborted ||
                       result.report.end == backend::MotionEnd::kUserStopped;
  return aborted ? "aborted" : "failed";
}

std::string SummaryJson(const scenario::Scenario& scenario, const RunResult& result,
                        bool interrupted, const std::optional<plant::ContactWatch>& contacts) {
  Json violations = Json::array();
  for (const Violation& violation : result.report.violations) {
    violations.push_back(Describe(violation));
  }
  const auto& pose = result.final_pose_error;
  // What became of commands, a robot at the other end of a wire does not tell.
  const auto known = [&](std::uint64_t count) {
    return scenario.is_remote() ? Json() : Json(count);
  };
  Json summary = HeadOf(scenario, OutcomeOf(result, interrupted), result.report.failure);
  summary.update(Json{
      {"violations", violations},
      {"simulated_s", ToSeconds(result.report.simulated)},
      {"final_error_rad", result.final_error},
      {"final_error_m", pose ? Json(pose->distance) : Json()},
      {"final_error_rotation_rad", pose ? Json(pose->angle) : Json()},
      {"q_final_rad", result.report.q_final},
      {"goal_rad", result.goal},
      {"cycles_served", known(result.counts.served)},
      {"cycles_held", known(result.counts.held)},
      {"longest_loss_cycles", known(result.counts.longest_loss)},
      {"commands_dropped", known(result.counts.dropped)},
      {"commands_written", result.report.timings.written},
      {"states_lost", result.report.timings.skipped_states},
      {"states_out_of_time", result.report.timings.anomalous},
      {"commands_of_a_stalled_source", result.report.timings.stalled},
      {"controller_overruns", result.report.controller_overruns},
      {"viability", ViabilityJson(result.viability)},
      {"hand", HandJson(scenario, result)},
      {"base", BaseJson(result)},
      {"plan", PlanJson(result)},
      {"contacts", ContactsJson(contacts)},
      {"d_EXT_us", PercentilesUs(result.report.timings.d_EXT)},
      {"period_us", PercentilesUs(result.report.timings.period)},
      {"libm", FormatHash(LibmFingerprint())},
      {"states_hash", FormatHash(result.states_hash)},
  });
  summary.update(DeviationJson(result.followed));
  return TextOf(summary);
}

std::string FailureJson(const scenario::Scenario& scenario, const std::string& failure) {
  return TextOf(HeadOf(scenario, "failed", failure));
}

std::string TimingJson(const WallTimes& times, const backend::RobotTimings& robot) {
  Json timing{
      {"prepare_s", times.prepare_s},
      {"planning_s", times.planning_s ? Json(*times.planning_s) : Json()},
      {"run_s", times.run_s},
      {"plots_s", times.plots_s},
      {"video_s", times.video_s},
      {"real_time_factor", times.real_time_factor},
      {"peak_memory_mb", times.peak_memory_mb},
  };
  if (robot.lateness.count() > 0) {
    timing["robot_cycle_late_us"] = PercentilesUs(robot.lateness);
    timing["robot_overruns"] = robot.overruns;
    timing["robot_commands_lost"] = robot.commands_lost;
    timing["records_dropped"] = times.records_dropped;
  }
  return TextOf(timing);
}

std::string SummaryText(const scenario::Scenario& scenario, const RunResult& result,
                        bool interrupted, const WallTimes& times,
                        const std::optional<plant::ContactWatch>& contacts) {
  std::string out;
  const auto line = [&out](std::string_view label, const std::string& text) {
    out += fmt::format("  {:<13}{}\n", label, text);
  };
  out += fmt::format("{}: {}\n", scenario.name, OutcomeOf(result, interrupted));
  for (const std::string& cure : CuresOf(scenario, result)) line("what to do", cure);
  const bool arrived = result.report.end == backend::MotionEnd::kSuccess;
  line(arrived ? "final error" : "to go", FinalErrorText(result) + ", to the last waypoint");
  const std::string deviation = DeviationText(result.followed.deviation);
  if (!deviation.empty()) line("deviation", deviation);
  if (result.plan) line("plan", PlanText(*result.plan));
  if (contacts && (result.plan || contacts->cycles() > 0)) {
    const bool is_odd = !arrived && !result.plan && scenario.motion.touches.empty();
    line("contacts", ContactsText(*contacts) + (is_odd ? "; validate refuses such a motion, unless "
                                                         "it says why the arm may touch "
                                                         "(motion.touches)"
                                                       : ""));
  }
  if (result.hand) line("hand", HandText(scenario, *result.hand));
  if (result.base) line("base", BaseText(*result.base));
  const bool is_remote = scenario.is_remote();
  line("cycles", is_remote ? RemoteCyclesText(result.report.timings) : CyclesText(result.counts));
  if (const std::uint64_t stalled = result.report.timings.stalled; stalled > 0) {
    line("stalled", fmt::format("the controller gave no new target in {} cycles beyond "
                                "tick.stall_time",
                                stalled));
  }
  if (result.viability) line("kept back", ViabilityText(*result.viability));
  const Duration planned_end = result.begun.time_since_epoch() + result.planned;
  const double settling = ToSeconds(result.report.simulated - planned_end);
  line("speed",
       fmt::format("{:.2f} s {}{} in {:.2f} s: {:.1f} x real time",
                   ToSeconds(result.report.simulated),
                   is_remote ? "of the robot's time" : "simulated",
                   settling > 0.1 ? fmt::format(" ({:.2f} s of it settling)", settling) : "",
                   times.run_s, times.real_time_factor));
  if (!scenario.is_lockstep()) {
    line("d_EXT", PercentilesText(result.report.timings.d_EXT));
    std::string late =
        fmt::format("{} states, not answered; {} wake-ups of the controller skipped",
                    result.report.timings.anomalous, result.report.controller_overruns);
    if (!is_remote) {
      late += fmt::format(" and {} cycles of the robot", result.report.robot_timings.overruns);
    }
    line("out of time", late);
    return out;
  }
  line("states hash",
       fmt::format("{} (libm {})", FormatHash(result.states_hash), FormatHash(LibmFingerprint())));
  return out;
}

}  // namespace twin::run
