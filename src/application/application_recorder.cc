#include <algorithm>
#include <cstddef>
#include <fstream>
#include <iterator>
#include <string_view>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "application/run_recorder.h"
#include "twin/application/application.h"
#include "twin/core/error.h"
#include "twin/core/hash.h"
#include "twin/render/image.h"
#include "twin/replay/plan_pictures.h"
#include "twin/report/page.h"
#include "twin/report/plot.h"

namespace twin::application {
namespace {

using Json = nlohmann::ordered_json;

double SecondsAt(Time time) {
  return ToSeconds(time.time_since_epoch());
}

/// @param on_page  adds texts for the page.
Json StepsJson(const TaskReport& task, bool on_page) {
  Json steps = Json::array();
  for (const StepReport& step : task.steps) {
    Json& one = steps.emplace_back(Json{{"step", step.name},
                                        {"attempt", step.attempt},
                                        {"begun_s", SecondsAt(step.begun)},
                                        {"ended_s", SecondsAt(step.ended)},
                                        {"succeeded", step.succeeded},
                                        {"text", step.text}});
    if (!on_page) continue;
    one["begun"] = fmt::format("{:.3f}", SecondsAt(step.begun));
    one["took"] = fmt::format("{:.3f}", ToSeconds(step.ended - step.begun));
  }
  return steps;
}

/// @param on_page  adds texts for the page.
Json FindingsJson(const Evaluation& evaluation, bool on_page) {
  Json findings = Json::array();
  for (const Finding& finding : evaluation.findings) {
    Json& one = findings.emplace_back(Json{{"quantity", finding.quantity},
                                           {"value", finding.value},
                                           {"unit", finding.unit},
                                           {"demand", finding.demand},
                                           {"met", finding.met ? Json(*finding.met) : Json()}});
    if (!on_page) continue;
    one["value"] = RoundedText(finding.value, finding.unit);
    one["verdict"] = !finding.met ? "reported" : *finding.met ? "met" : "missed";
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

std::string ReadForPage(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  if (!in) throw EnvironmentError(fmt::format("{}: cannot be read for the page", path.string()));
  return bytes;
}

std::string EncodedPicture(const std::filesystem::path& png) {
  return png.empty() ? std::string() : report::Base64(ReadForPage(png));
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

class ApplicationRecorder final : public RunRecorder {
 public:
  explicit ApplicationRecorder(const RunInputs& inputs)
      : RunRecorder(inputs),
        devices_(page_.Devices(inputs.catalogue)),
        catalogue_{inputs.catalogue.backends, inputs.catalogue.controllers, &devices_} {}

 private:
  Connected Connect(const run::RealtimeConfig& settings) override {
    run_.emplace(scenario(), catalogue_, inputs_.files, page_.sink(), clock_, settings,
                 inputs_.partners);
    return {.connection = &run_->connection(),
            .robot = &run_->robot(),
            .check_start = [this](const run::TellCheck& tell) { return run_->CheckStart(tell); },
            .start = scenario().robot.q_start,
            .longest = run_->longest()};
  }
  Outcome Perform(const run::RunHooks& hooks) override;
  void Evaluate(Outcome& outcome) override;
  std::string SummaryOfFile() const override;
  std::string SummaryOfTerminal() const override;
  /// Two pictures of each plan: NUMBER_ID_plan.png and NUMBER_ID.png.
  void Draw(const render::Film& film, replay::PlanPictures& pictures) override;
  void WriteReport(const std::vector<std::filesystem::path>& plots) const override;
  [[nodiscard]] const char* outcome() const {
    if (was_interrupted_) return "interrupted";
    return FailureOf(run_->task_result(), run_->evaluation()).empty() ? "success" : "failed";
  }

  const teleop::DeviceRegistry devices_;  ///< the page's among them
  const run::Catalogue catalogue_;
  std::optional<ApplicationRun> run_;
  Duration simulated_{};
  bool was_interrupted_ = false;
  std::vector<PicturePair> pictures_;
};

RunRecorder::Outcome ApplicationRecorder::Perform(const run::RunHooks& hooks) {
  const TaskResult& task_result = run_->Execute(
      hooks, [this](std::string_view line) { inputs_.console.Print(fmt::format("{}\n", line)); });
  times_.planning_s = ToSeconds(task_result.planning_time);
  was_interrupted_ = is_interrupted();
  Outcome outcome{.plans = task_result.plans,
                  .followed = run_->session_result().followed,
                  .robot = run_->session_result().robot_timings,
                  .lost_recording = task_result.lost_recording};
  if (!task_result.task.steps.empty()) {
    outcome.simulated = task_result.task.steps.back().ended.time_since_epoch();
  }
  simulated_ = outcome.simulated;
  return outcome;
}

void ApplicationRecorder::Evaluate(Outcome& outcome) {
  if (was_interrupted_) {
    outcome.failure = "it was broken off";
    return;
  }
  const Evaluation& evaluation =
      run_->Evaluate({.log = scenario().record ? out_.log() : std::filesystem::path(),
                      .contacts = records_.contacts() ? &*records_.contacts() : nullptr});
  outcome.failure = FailureOf(run_->task_result(), evaluation);
}

std::string ApplicationRecorder::SummaryOfFile() const {
  // A remote robot does not count its commands.
  const bool is_remote = scenario().is_remote();
  const auto known = [&](std::uint64_t count) { return is_remote ? Json() : Json(count); };
  const run::SessionResult& session = run_->session_result();
  const run::CycleCounts& counts = session.counts;
  return run::TextOf({
      {"scenario", scenario().name},
      {"application", scenario().application->type},
      {"seed", scenario().seed},
      {"drive", scenario().drive_name()},
      {"version", TWIN_VERSION},
      {"outcome", outcome()},
      {"failure", FailureOf(run_->task_result(), run_->evaluation())},
      {"steps", StepsJson(run_->task_result().task, false)},
      {"findings", FindingsJson(run_->evaluation(), false)},
      {"simulated_s", ToSeconds(simulated_)},
      {"motions", session.motions},
      {"deviations", DeviationsJson(session.followed)},
      {"deviation_exceeded", std::ranges::any_of(session.followed, &run::FollowedMotion::exceeds)},
      {"cycles_served", known(counts.served)},
      {"cycles_held", known(counts.held)},
      {"longest_loss_cycles", known(counts.longest_loss)},
      {"commands_dropped", known(counts.dropped)},
      {"viability", run::ViabilityJson(session.viability)},
      {"contacts", run::ContactsJson(records_.contacts())},
      {"libm", FormatHash(LibmFingerprint())},
      {"states_hash", FormatHash(session.states_hash)},
  });
}

std::string ApplicationRecorder::SummaryOfTerminal() const {
  const run::SessionResult& session = run_->session_result();
  std::string out = fmt::format("{}: {}\n", scenario().name, outcome());
  for (const Finding& finding : run_->evaluation().findings) {
    out += fmt::format("  {:<7}{}: {}{}{}{}\n",
                       !finding.met   ? " "
                       : *finding.met ? "met"
                                      : "MISSED",
                       finding.quantity, RoundedText(finding.value, finding.unit),
                       finding.unit.empty() ? "" : " ", finding.unit,
                       finding.demand.empty() ? "" : fmt::format(" ({})", finding.demand));
  }
  const run::CycleCounts& counts = session.counts;
  if (!scenario().is_remote()) {
    out += fmt::format("  {:<13}{} in {} motions; {} served, {} held (at most {} in a row)\n",
                       "cycles", counts.cycles(), session.motions, counts.served, counts.held,
                       counts.longest_loss);
  }
  if (session.viability) {
    out += fmt::format("  {:<13}{}\n", "kept back", run::ViabilityText(*session.viability));
  }
  out += fmt::format("  {:<13}{:.2f} s: {:.1f} x real time; of it planning {:.2f} s\n", "took",
                     times_.run_s, times_.real_time_factor, times_.planning_s.value_or(0));
  if (scenario().is_lockstep()) {
    out += fmt::format("  {:<13}{} (libm {})\n", "states hash", FormatHash(session.states_hash),
                       FormatHash(LibmFingerprint()));
  }
  return out;
}

void ApplicationRecorder::Draw(const render::Film& film, replay::PlanPictures& pictures) {
  run::MakeFolder(out_.snapshots());
  for (std::size_t i = 0; i < run_->task_result().plans.size(); ++i) {
    const std::string name = fmt::format("{}_{}", i + 1, run_->task_result().plans[i].id);
    const PicturePair& pair = pictures_.emplace_back(
        PicturePair{out_.snapshots() / (name + "_plan.png"), out_.snapshots() / (name + ".png")});
    render::WritePng(pair.planned, pictures.Planned(film.goals[i]));
    render::WritePng(pair.done, pictures.Done(film.goals[i]));
  }
}

void ApplicationRecorder::WriteReport(const std::vector<std::filesystem::path>& plots) const {
  PageFacts facts{.pictures = pictures_, .plots = plots, .has_video = is_filmed()};
  facts.lines = {{"application", scenario().application->type},
                 {"seed", fmt::format("{}", scenario().seed)},
                 {"site", inputs_.options.site},
                 {"backend", scenario().backend},
                 {"drive", std::string(scenario().drive_name())},
                 {"motions", fmt::format("{}", run_->session_result().motions)},
                 {"panda-twin", TWIN_VERSION}};
  run::WriteWholeFile(out_.report(),
                      PageOf(scenario(), run_->task_result(), run_->evaluation(), facts));
}

}  // namespace

std::string PageOf(const scenario::Scenario& scenario, const TaskResult& task_result,
                   const Evaluation& evaluation, const PageFacts& facts) {
  const std::string failure = FailureOf(task_result, evaluation);
  return report::RenderPage("application/run", {{"title", scenario.name},
                                                {"description", scenario.description},
                                                {"verdict", VerdictOf(evaluation)},
                                                {"succeeded", failure.empty()},
                                                {"failure", failure},
                                                {"video", facts.has_video},
                                                {"judged", !evaluation.findings.empty()},
                                                {"findings", FindingsJson(evaluation, true)},
                                                {"steps", StepsJson(task_result.task, true)},
                                                {"pictured", !facts.pictures.empty()},
                                                {"snapshots", PlansOnPage(task_result, facts)},
                                                {"figures", FiguresOnPage(evaluation)},
                                                {"plotted", !facts.plots.empty()},
                                                {"plots", PlotsOnPage(facts.plots)},
                                                {"facts", report::FactsOf(facts.lines)}});
}

std::unique_ptr<RunRecorder> MakeApplicationRecorder(const RunInputs& inputs) {
  return std::make_unique<ApplicationRecorder>(inputs);
}

}  // namespace twin::application
