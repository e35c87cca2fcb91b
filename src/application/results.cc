#include "application/results.h"

#include <algorithm>
#include <cstddef>
#include <fstream>
#include <iterator>

#include <fmt/format.h>

#include "twin/core/error.h"
#include "twin/core/hash.h"
#include "twin/report/page.h"
#include "twin/report/plot.h"

namespace twin::application {
namespace {

using Json = nlohmann::ordered_json;

double SecondsAt(Time time) {
  return ToSeconds(time.time_since_epoch());
}

Json StepsJson(const TaskReport& task) {
  Json steps = Json::array();
  for (const StepReport& step : task.steps) {
    steps.push_back({{"step", step.name},
                     {"attempt", step.attempt},
                     {"begun_s", SecondsAt(step.begun)},
                     {"ended_s", SecondsAt(step.ended)},
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
    Json one{{"motion", motion.name}, {"begun_s", SecondsAt(motion.begun)}};
    one.update(run::DeviationJson(motion));
    deviations.push_back(std::move(one));
  }
  return deviations;
}

std::string OutcomeOf(const ApplicationResult& result) {
  if (result.interrupted) return "interrupted";
  return Succeeded(result.task_result, result.evaluation) ? "success" : "failed";
}

std::string ReadForPage(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  if (!in) throw EnvironmentError(fmt::format("{}: cannot be read for the page", path.string()));
  return bytes;
}

std::string EncodedPicture(const std::filesystem::path& png) {
  return png.empty() ? std::string() : report::Base64(ReadForPage(png));
}

Json FindingsOnPage(const Evaluation& evaluation) {
  Json findings = FindingsJson(evaluation);
  for (Json& finding : findings) {
    const Json met = finding["met"];
    finding["verdict"] = met.is_null() ? "reported" : met.get<bool>() ? "met" : "missed";
  }
  return findings;
}

Json StepsOnPage(const TaskReport& task) {
  Json steps = StepsJson(task);
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const StepReport& step = task.steps[i];
    steps[i]["begun"] = fmt::format("{:.3f}", SecondsAt(step.begun));
    steps[i]["took"] = fmt::format("{:.3f}", ToSeconds(step.ended - step.begun));
  }
  return steps;
}

Json PlansOnPage(const TaskResult& task_result, const PageFacts& facts) {
  Json plans = Json::array();
  for (std::size_t i = 0; i < std::min(facts.pictures.size(), task_result.plans.size()); ++i) {
    const record::PlanRecord& plan = task_result.plans[i];
    plans.push_back({{"number", i + 1},
                     {"caption", plan.caption},
                     {"planned_s", fmt::format("{:.2f}", SecondsAt(plan.from))},
                     {"done_s", fmt::format("{:.2f}", SecondsAt(plan.until))},
                     {"planned", EncodedPicture(facts.pictures[i].planned)},
                     {"done", EncodedPicture(facts.pictures[i].done)}});
  }
  return plans;
}

Json FiguresOnPage(const Evaluation& evaluation) {
  Json figures = Json::object();
  for (const report::Figure& figure : evaluation.figures) {
    Json& one = figures[figure.id] = figure.values;
    one["svg"] = report::InlineSvg(report::DrawPlot("application/", figure), figure.id);
  }
  return figures;
}

Json PlotsOnPage(const std::vector<std::filesystem::path>& plots) {
  Json list = Json::array();
  for (const std::filesystem::path& plot : plots) {
    const std::string name = plot.stem().string();
    list.push_back({{"name", name}, {"svg", report::InlineSvg(ReadForPage(plot), name)}});
  }
  return list;
}

}  // namespace

std::string SummaryJson(const scenario::Scenario& scenario, const ApplicationResult& result,
                        const std::optional<plant::ContactWatch>& contacts) {
  // A remote robot does not count its commands.
  const bool is_remote = scenario.is_remote();
  const auto known = [&](std::uint64_t count) { return is_remote ? Json() : Json(count); };
  const run::CycleCounts& counts = result.session.counts;
  return run::TextOf({
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
  });
}

std::string SummaryText(const scenario::Scenario& scenario, const ApplicationResult& result,
                        const run::WallTimes& times) {
  std::string out = fmt::format("{}: {}\n", scenario.name, OutcomeOf(result));
  for (const Finding& finding : result.evaluation.findings) {
    out +=
        fmt::format("  {:<7}{}: {:.4g}{}{}{}\n",
                    !finding.met   ? " "
                    : *finding.met ? "met"
                                   : "MISSED",
                    finding.quantity, finding.value, finding.unit.empty() ? "" : " ", finding.unit,
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

std::string PageOf(const scenario::Scenario& scenario, const TaskResult& task_result,
                   const Evaluation& evaluation, const PageFacts& facts) {
  return report::RenderPage("application/run", {{"title", scenario.name},
                                                {"description", scenario.description},
                                                {"succeeded", Succeeded(task_result, evaluation)},
                                                {"failure", FailureOf(task_result, evaluation)},
                                                {"video", facts.has_video},
                                                {"judged", !evaluation.findings.empty()},
                                                {"findings", FindingsOnPage(evaluation)},
                                                {"steps", StepsOnPage(task_result.task)},
                                                {"pictured", !facts.pictures.empty()},
                                                {"snapshots", PlansOnPage(task_result, facts)},
                                                {"figures", FiguresOnPage(evaluation)},
                                                {"plotted", !facts.plots.empty()},
                                                {"plots", PlotsOnPage(facts.plots)},
                                                {"facts", report::FactsOf(facts.lines)}});
}

}  // namespace twin::application
