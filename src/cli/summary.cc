#include "cli/summary.h"

#include <iterator>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "cli/advice.h"
#include "twin/scenario/fingerprint.h"

namespace twin::cli {
namespace {

/// A JSON string.
std::string Quoted(std::string_view text) {
  std::string quoted = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      quoted += '\\';
      quoted += c;
    } else if (byte < 0x20) {
      quoted += fmt::format("\\u{:04x}", byte);
    } else {
      quoted += c;
    }
  }
  return quoted + '"';
}

std::string ViolationsJson(const std::vector<Violation>& violations) {
  std::string list;
  for (const Violation& violation : violations) {
    list += (list.empty() ? "" : ", ") + Quoted(Describe(violation));
  }
  return "[" + list + "]";
}

}  // namespace

std::string OutcomeOf(const scenario::RunResult& result, bool interrupted) {
  if (result.report.succeeded()) return "success";
  if (interrupted) return "interrupted";
  return result.report.end == backend::MotionEnd::kAborted ? "aborted" : "failed";
}

std::string SummaryJson(const scenario::Scenario& scenario, const scenario::RunResult& result,
                        bool interrupted) {
  std::string text = "{\n";
  const auto put = [&](std::string_view key, const std::string& value) {
    text += fmt::format("  \"{}\": {},\n", key, value);
  };
  put("scenario", Quoted(scenario.name));
  put("seed", fmt::format("{}", scenario.seed));
  put("version", Quoted(TWIN_VERSION));
  put("outcome", Quoted(OutcomeOf(result, interrupted)));
  put("failure", Quoted(result.report.failure));
  put("violations", ViolationsJson(result.report.violations));
  put("simulated_s", fmt::format("{}", ToSeconds(result.report.simulated)));
  put("final_error_rad", fmt::format("{}", result.final_error));
  put("q_final_rad", fmt::format("[{}]", fmt::join(result.report.q_final, ", ")));
  put("goal_rad", fmt::format("[{}]", fmt::join(result.goal, ", ")));
  put("cycles_served", fmt::format("{}", result.counts.served));
  put("cycles_held", fmt::format("{}", result.counts.held));
  put("longest_loss_cycles", fmt::format("{}", result.counts.longest_loss));
  put("commands_dropped", fmt::format("{}", result.counts.dropped));
  put("commands_written", fmt::format("{}", result.report.written));
  put("states_lost", fmt::format("{}", result.report.skipped_states));
  put("libm", Quoted(scenario::FormatHash(scenario::LibmFingerprint())));
  text +=
      fmt::format("  \"states_hash\": {}\n}}\n", Quoted(scenario::FormatHash(result.states_hash)));
  return text;
}

std::string TimingJson(const WallTimes& times) {
  return fmt::format(
      "{{\n  \"prepare_s\": {:.6f},\n  \"run_s\": {:.6f},\n  \"plots_s\": {:.6f},\n"
      "  \"video_s\": {:.6f},\n  \"real_time_factor\": {:.3f},\n  \"peak_memory_mb\": {:.1f}\n}}\n",
      times.prepare_s, times.run_s, times.plots_s, times.video_s, times.real_time_factor,
      times.peak_memory_mb);
}

std::string SummaryText(const scenario::Scenario& scenario, const scenario::RunResult& result,
                        bool interrupted, const WallTimes& times) {
  const auto& counts = result.counts;
  const double all = static_cast<double>(counts.served + counts.held);
  fmt::memory_buffer out;
  const auto line = [&out](std::string_view label, const std::string& text) {
    fmt::format_to(std::back_inserter(out), "  {:<13}{}\n", label, text);
  };
  fmt::format_to(std::back_inserter(out), "{}: {}\n", scenario.name,
                 OutcomeOf(result, interrupted));
  for (const Violation& violation : result.report.violations) {
    line("violation", Describe(violation));
    line("what to do", std::string(Advice(violation.error)));
  }
  line("final error",
       fmt::format("{:.2e} rad, largest of the joints, to the last waypoint", result.final_error));
  line("cycles",
       fmt::format("{} served, {} held ({:.2f} %, at most {} in a row); {} commands dropped",
                   counts.served, counts.held,
                   all > 0 ? 100 * static_cast<double>(counts.held) / all : 0, counts.longest_loss,
                   counts.dropped));
  line("speed",
       fmt::format("{:.2f} s simulated in {:.2f} s: {:.1f} x real time",
                   ToSeconds(result.report.simulated), times.run_s, times.real_time_factor));
  line("states hash", fmt::format("{} (libm {})", scenario::FormatHash(result.states_hash),
                                  scenario::FormatHash(scenario::LibmFingerprint())));
  return fmt::to_string(out);
}

}  // namespace twin::cli
