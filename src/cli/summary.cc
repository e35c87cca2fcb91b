#include "cli/summary.h"

#include <algorithm>
#include <iterator>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "twin/core/error_catalogue.h"
#include "twin/scenario/fingerprint.h"

namespace twin::cli {
namespace {

using Json = nlohmann::ordered_json;

/// Text of a file. Texts may hold bytes of a user's file names: what is no UTF-8 is replaced.
std::string ToText(const Json& json) {
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

double Microseconds(Duration duration) {
  return ToSeconds(duration) * 1e6;
}

Json PercentilesUs(const rt::DurationHistogram& histogram) {
  return {{"count", histogram.count()},
          {"p50", Microseconds(histogram.Percentile(0.5))},
          {"p99", Microseconds(histogram.Percentile(0.99))},
          {"p99.9", Microseconds(histogram.Percentile(0.999))},
          {"max", Microseconds(histogram.max())}};
}

std::string PercentilesText(const rt::DurationHistogram& histogram) {
  return fmt::format("{:.1f} / {:.1f} / {:.1f} us (median, p99, max)",
                     Microseconds(histogram.Percentile(0.5)),
                     Microseconds(histogram.Percentile(0.99)), Microseconds(histogram.max()));
}

/// What helps against the errors that ended the run, each text once.
std::vector<std::string> CuresOf(const scenario::Scenario& scenario,
                                 const scenario::RunResult& result) {
  const TimeKeeper keeper = scenario.drive == scenario::Drive::kRealtime
                                ? TimeKeeper::kWallClock
                                : TimeKeeper::kVirtualClock;
  std::vector<std::string> cures;
  for (const Violation& violation : result.report.violations) {
    std::string cure(CureHere(EntryOf(violation), keeper));
    if (std::ranges::find(cures, cure) == cures.end()) cures.push_back(std::move(cure));
  }
  return cures;
}

}  // namespace

std::string OutcomeOf(const scenario::RunResult& result, bool interrupted) {
  if (result.report.succeeded()) return "success";
  if (interrupted) return "interrupted";
  const bool aborted = result.report.end == backend::MotionEnd::kAborted ||
                       result.report.end == backend::MotionEnd::kUserStopped;
  return aborted ? "aborted" : "failed";
}

std::string SummaryJson(const scenario::Scenario& scenario, const scenario::RunResult& result,
                        bool interrupted, const std::optional<report::Deviation>& deviation) {
  Json violations = Json::array();
  for (const Violation& violation : result.report.violations) {
    violations.push_back(Describe(violation));
  }
  const Json summary{
      {"scenario", scenario.name},
      {"seed", scenario.seed},
      {"drive", Name(scenario.drive)},
      {"version", TWIN_VERSION},
      {"outcome", OutcomeOf(result, interrupted)},
      {"failure", result.report.failure},
      {"violations", violations},
      {"simulated_s", ToSeconds(result.report.simulated)},
      {"final_error_rad", result.final_error},
      {"deviation_rad", deviation ? Json(deviation->largest) : Json()},
      {"q_final_rad", result.report.q_final},
      {"goal_rad", result.goal},
      {"cycles_served", result.counts.served},
      {"cycles_held", result.counts.held},
      {"longest_loss_cycles", result.counts.longest_loss},
      {"commands_dropped", result.counts.dropped},
      {"commands_written", result.report.timings.written},
      {"states_lost", result.report.timings.skipped_states},
      {"states_out_of_time", result.report.timings.anomalous},
      {"controller_overruns", result.report.controller_overruns},
      {"d_EXT_us", PercentilesUs(result.report.timings.d_EXT)},
      {"period_us", PercentilesUs(result.report.timings.period)},
      {"libm", scenario::FormatHash(scenario::LibmFingerprint())},
      {"states_hash", scenario::FormatHash(result.states_hash)},
  };
  return ToText(summary);
}

std::string TimingJson(const WallTimes& times, const backend::RobotTimings& robot) {
  Json timing{
      {"prepare_s", times.prepare_s},
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
  return ToText(timing);
}

std::string SummaryText(const scenario::Scenario& scenario, const scenario::RunResult& result,
                        bool interrupted, const WallTimes& times,
                        const std::optional<report::Deviation>& deviation) {
  const auto& counts = result.counts;
  const double all = static_cast<double>(counts.served + counts.held);
  fmt::memory_buffer out;
  const auto line = [&out](std::string_view label, const std::string& text) {
    fmt::format_to(std::back_inserter(out), "  {:<13}{}\n", label, text);
  };
  fmt::format_to(std::back_inserter(out), "{}: {}\n", scenario.name,
                 OutcomeOf(result, interrupted));
  for (const std::string& cure : CuresOf(scenario, result)) line("what to do", cure);
  const bool arrived = result.report.end == backend::MotionEnd::kSuccess;
  line(arrived ? "final error" : "to go",
       fmt::format("{:.2e} rad, largest of the joints, to the last waypoint", result.final_error));
  if (deviation) {
    line("deviation",
         fmt::format("{:.2e} rad at most (joint {}, at {:.2f} s; rms {:.2e}), arm from "
                     "planned target, delay included",
                     deviation->largest, deviation->joint + 1, deviation->at, deviation->rms));
  }
  line("cycles",
       fmt::format("{} served, {} held ({:.2f} %, at most {} in a row); {} commands dropped",
                   counts.served, counts.held,
                   all > 0 ? 100 * static_cast<double>(counts.held) / all : 0, counts.longest_loss,
                   counts.dropped));
  line("speed",
       fmt::format("{:.2f} s simulated in {:.2f} s: {:.1f} x real time",
                   ToSeconds(result.report.simulated), times.run_s, times.real_time_factor));
  if (scenario.drive == scenario::Drive::kRealtime) {
    line("d_EXT", PercentilesText(result.report.timings.d_EXT));
    line("out of time",
         fmt::format("{} states, not answered; {} wake-ups of the controller and {} "
                     "cycles of the robot skipped",
                     result.report.timings.anomalous, result.report.controller_overruns,
                     result.report.robot_timings.overruns));
    return fmt::to_string(out);
  }
  line("states hash", fmt::format("{} (libm {})", scenario::FormatHash(result.states_hash),
                                  scenario::FormatHash(scenario::LibmFingerprint())));
  return fmt::to_string(out);
}

}  // namespace twin::cli
