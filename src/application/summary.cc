#include "twin/application/summary.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "twin/application/page.h"
#include "twin/core/fingerprint.h"

namespace twin::application {
namespace {

using Json = nlohmann::ordered_json;

Json StepsJson(const TaskReport& task) {
  Json steps = Json::array();
  for (const StepReport& step : task.steps) {
    steps.push_back({{"step", step.name},
                     {"attempt", step.attempt},
                     {"begun_s", ToSeconds(step.begun.time_since_epoch())},
                     {"ended_s", ToSeconds(step.ended.time_since_epoch())},
                     {"succeeded", step.succeeded},
                     {"text", step.text}});
  }
  return steps;
}

Json FindingsJson(const Evaluation& evaluation) {
  Json findings = Json::array();
  for (const Finding& finding : evaluation.findings) {
    findings.push_back({{"quantity", finding.quantity},
                        {"value", finding.value},
                        {"unit", finding.unit},
                        {"demand", finding.demand},
                        {"met", finding.met ? Json(*finding.met) : Json()}});
  }
  return findings;
}

Json DeviationsJson(const std::vector<run::FollowedMotion>& motions) {
  Json deviations = Json::array();
  for (const run::FollowedMotion& motion : motions) {
    Json one{{"motion", motion.name}, {"begun_s", ToSeconds(motion.begun.time_since_epoch())}};
    one.update(run::DeviationJson(motion));
    deviations.push_back(std::move(one));
  }
  return deviations;
}

std::string_view Mark(const Finding& finding) {
  if (!finding.met) return " ";
  return *finding.met ? "met" : "MISSED";
}

}  // namespace

std::string OutcomeOf(const ApplicationResult& result) {
  if (result.interrupted) return "interrupted";
  return Succeeded(result.task_result, result.evaluation) ? "success" : "failed";
}

std::string SummaryJson(const scenario::Scenario& scenario, const ApplicationResult& result,
                        const std::optional<plant::ContactWatch>& contacts) {
  // What became of commands, a robot at the other end of a wire does not tell.
  const bool is_remote = scenario.is_remote();
  const auto known = [&](std::uint64_t count) { return is_remote ? Json() : Json(count); };
  const run::CycleCounts& counts = result.session.counts;
  const Json summary{
      {"scenario", scenario.name},
      {"application", scenario.application->type},
      {"seed", scenario.seed},
      {"drive", scenario.drive_name()},
      {"version", TWIN_VERSION},
      {"outcome", OutcomeOf(result)},
      {"failure", FailureOf(result.task_result, result.evaluation)},
      {"steps", StepsJson(result.task_result.task)},
      {"findings", FindingsJson(result.evaluation)},
      {"motions", result.session.motions},
      {"deviations", DeviationsJson(result.session.followed)},
      {"deviation_exceeded",
       std::ranges::any_of(result.session.followed, &run::FollowedMotion::exceeds)},
      {"cycles_served", known(counts.served)},
      {"cycles_held", known(counts.held)},
      {"longest_loss_cycles", known(counts.longest_loss)},
      {"commands_dropped", known(counts.dropped)},
      {"viability", run::ViabilityJson(result.session.viability)},
      {"contacts", run::ContactsJson(contacts)},
      {"libm", FormatHash(LibmFingerprint())},
      {"states_hash", FormatHash(result.session.states_hash)},
  };
  return run::TextOf(summary);
}

std::string SummaryText(const scenario::Scenario& scenario, const ApplicationResult& result,
                        const run::WallTimes& times) {
  std::string out = fmt::format("{}: {}\n", scenario.name, OutcomeOf(result));
  for (const Finding& finding : result.evaluation.findings) {
    out += fmt::format("  {:<7}{}: {:.4g}{}{}{}\n", Mark(finding), finding.quantity, finding.value,
                       finding.unit.empty() ? "" : " ", finding.unit,
                       finding.demand.empty() ? "" : fmt::format(" ({})", finding.demand));
  }
  const run::CycleCounts& counts = result.session.counts;
  if (!scenario.is_remote()) {
    out += fmt::format("  {:<13}{} in {} motions; {} served, {} held (at most {} in a row)\n",
                       "cycles", counts.cycles(), result.session.motions, counts.served,
                       counts.held, counts.longest_loss);
  }
  if (result.session.viability) {
    out += fmt::format("  {:<13}{}\n", "kept back", run::ViabilityText(*result.session.viability));
  }
  out += fmt::format("  {:<13}{:.2f} s: {:.1f} x real time; of it planning {:.2f} s\n", "took",
                     times.run_s, times.real_time_factor, times.planning_s.value_or(0));
  if (scenario.is_lockstep()) {
    out += fmt::format("  {:<13}{} (libm {})\n", "states hash",
                       FormatHash(result.session.states_hash), FormatHash(LibmFingerprint()));
  }
  return out;
}

}  // namespace twin::application
