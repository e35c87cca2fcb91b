#include "twin/application/page.h"

#include <algorithm>
#include <cstddef>
#include <fstream>
#include <iterator>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "twin/core/error.h"
#include "twin/report/page.h"
#include "twin/report/plot.h"

namespace twin::application {
namespace {

using nlohmann::json;

std::string ReadFile(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  if (!in) throw EnvironmentError(fmt::format("{}: cannot be read for the page", path.string()));
  return bytes;
}

std::string PictureOf(const std::filesystem::path& png) {
  return png.empty() ? std::string() : report::Base64(ReadFile(png));
}

json FindingsOf(const Evaluation& evaluation) {
  json list = json::array();
  for (const Finding& finding : evaluation.findings) {
    const char* const verdict = !finding.met ? "reported" : *finding.met ? "met" : "missed";
    list.push_back({{"quantity", finding.quantity},
                    {"value", finding.value},
                    {"unit", finding.unit},
                    {"demand", finding.demand},
                    {"verdict", verdict}});
  }
  return list;
}

json StepsOf(const TaskReport& task) {
  json list = json::array();
  for (const StepReport& step : task.steps) {
    list.push_back({{"name", step.name},
                    {"attempt", step.attempt},
                    {"begun_s", fmt::format("{:.3f}", ToSeconds(step.begun.time_since_epoch()))},
                    {"took_s", fmt::format("{:.3f}", ToSeconds(step.ended - step.begun))},
                    {"succeeded", step.succeeded},
                    {"text", step.text}});
  }
  return list;
}

json SnapshotsOf(const TaskResult& task_result, const PageFacts& facts) {
  json list = json::array();
  const auto seconds = [](Time time) {
    return fmt::format("{:.2f}", ToSeconds(time.time_since_epoch()));
  };
  for (std::size_t i = 0; i < std::min(facts.snapshots.size(), task_result.snapshots.size()); ++i) {
    const Snapshot& snapshot = task_result.snapshots[i];
    list.push_back({{"number", i + 1},
                    {"caption", snapshot.caption},
                    {"planned_s", seconds(snapshot.planned)},
                    {"done_s", seconds(snapshot.done)},
                    {"planned", PictureOf(facts.snapshots[i].planned)},
                    {"done", PictureOf(facts.snapshots[i].done)}});
  }
  return list;
}

json FiguresOf(const Evaluation& evaluation) {
  json all = json::object();
  for (const report::Figure& figure : evaluation.figures) {
    const std::string svg = report::DrawPlot("application/", figure);
    json& one = all[figure.id] = figure.values;
    one["svg"] = report::InlineSvg(svg, figure.id);
  }
  return all;
}

json PlotsOf(const std::vector<std::filesystem::path>& plots) {
  json list = json::array();
  for (const std::filesystem::path& plot : plots) {
    const std::string name = plot.stem().string();
    list.push_back({{"name", name}, {"svg", report::InlineSvg(ReadFile(plot), name)}});
  }
  return list;
}

}  // namespace

bool Succeeded(const TaskResult& task_result, const Evaluation& evaluation) noexcept {
  return task_result.task.failure.empty() &&
         std::ranges::none_of(evaluation.findings,
                              [](const Finding& finding) { return finding.met == false; });
}

std::string FailureOf(const TaskResult& task_result, const Evaluation& evaluation) {
  if (!task_result.task.failure.empty()) return task_result.task.failure;
  for (const Finding& finding : evaluation.findings) {
    if (finding.met != false) continue;
    return fmt::format("{} is {:.4g}{}{}; demanded: {}", finding.quantity, finding.value,
                       finding.unit.empty() ? "" : " ", finding.unit, finding.demand);
  }
  return {};
}

std::string PageOf(const scenario::Scenario& scenario, const TaskResult& task_result,
                   const Evaluation& evaluation, const PageFacts& facts) {
  return report::RenderPage("application/run", {{"title", scenario.name},
                                                {"description", scenario.description},
                                                {"succeeded", Succeeded(task_result, evaluation)},
                                                {"failure", FailureOf(task_result, evaluation)},
                                                {"video", facts.has_video},
                                                {"judged", !evaluation.findings.empty()},
                                                {"findings", FindingsOf(evaluation)},
                                                {"steps", StepsOf(task_result.task)},
                                                {"pictured", !facts.snapshots.empty()},
                                                {"snapshots", SnapshotsOf(task_result, facts)},
                                                {"figures", FiguresOf(evaluation)},
                                                {"plotted", !facts.plots.empty()},
                                                {"plots", PlotsOf(facts.plots)},
                                                {"facts", report::FactsOf(facts.lines)}});
}

}  // namespace twin::application
