#include "twin/application/page.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <fstream>
#include <iterator>
#include <string_view>

#include <fmt/format.h>

#include "twin/core/error.h"
#include "twin/report/html.h"

namespace twin::application {
namespace {

using report::Escape;

std::string ReadFile(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  if (!in) throw EnvironmentError(fmt::format("{}: cannot be read for the page", path.string()));
  return bytes;
}

std::string PictureHtml(const std::filesystem::path& png, std::string_view what) {
  if (png.empty()) return {};
  return fmt::format("<img alt=\"{}\" src=\"data:image/png;base64,{}\">", Escape(what),
                     report::Base64(ReadFile(png)));
}

std::string_view VerdictOf(const Finding& finding) {
  if (!finding.met) return "reported";
  return *finding.met ? "met" : "missed";
}

std::string FindingsHtml(const std::vector<Finding>& findings) {
  if (findings.empty()) return {};
  std::string html =
      "<h2>What came of it</h2>\n<div class=\"wide\"><table>\n<tr><th>quantity</th><th>value</th>"
      "<th>unit</th><th>demanded</th><th>verdict</th></tr>\n";
  for (const Finding& finding : findings) {
    const std::string_view verdict = VerdictOf(finding);
    html += fmt::format(
        "<tr><td>{}</td><td>{:.4g}</td><td class=\"word\">{}</td><td class=\"word\">{}</td>"
        "<td class=\"{}\">{}</td></tr>\n",
        Escape(finding.quantity), finding.value, Escape(finding.unit), Escape(finding.demand),
        verdict, verdict);
  }
  return html + "</table></div>\n";
}

std::string StepsHtml(const TaskReport& task) {
  std::string html =
      "<h2>Steps</h2>\n<div class=\"wide\"><table>\n<tr><th>step</th><th>attempt</th><th>begun "
      "[s]</th><th>took [s]</th><th>outcome</th><th></th></tr>\n";
  for (const StepReport& step : task.steps) {
    html += fmt::format(
        "<tr><td>{}</td><td>{}</td><td>{:.3f}</td><td>{:.3f}</td><td class=\"{}\">{}</td>"
        "<td class=\"word\">{}</td></tr>\n",
        Escape(step.name), step.attempt, ToSeconds(step.begun.time_since_epoch()),
        ToSeconds(step.ended - step.begun), step.succeeded ? "met" : "failed",
        step.succeeded ? "done" : "failed", Escape(step.text));
  }
  return html + "</table></div>\n";
}

std::string SnapshotsHtml(const TaskResult& task_result, const PageFacts& facts) {
  if (facts.snapshots.empty()) return {};
  std::string html =
      "<h2>Planned and done</h2>\n<p>Left, before each motion: the arm as it is, its goal as a "
      "ghost, the way of its end effector as a line. Right: where it came to.</p>\n";
  const std::size_t pairs = std::min(facts.snapshots.size(), task_result.snapshots.size());
  for (std::size_t i = 0; i < pairs; ++i) {
    const Snapshot& snapshot = task_result.snapshots[i];
    html += fmt::format(
        "<figure class=\"pair\"><figcaption>{}. {} <span class=\"run\">{:.2f} s to {:.2f} "
        "s</span></figcaption>\n{}{}</figure>\n",
        i + 1, Escape(snapshot.caption), ToSeconds(snapshot.planned.time_since_epoch()),
        ToSeconds(snapshot.done.time_since_epoch()),
        PictureHtml(facts.snapshots[i].planned, snapshot.caption + " (planned)"),
        PictureHtml(facts.snapshots[i].done, snapshot.caption + " (done)"));
  }
  return html;
}

std::string FiguresHtml(const std::vector<Figure>& figures) {
  std::string html;
  for (const Figure& figure : figures) {
    html += fmt::format("<h2>{}</h2>\n<figure>\n<figcaption>{}</figcaption>\n{}</figure>\n",
                        Escape(figure.title), Escape(figure.what),
                        report::InlineSvg(figure.svg, figure.id));
  }
  return html;
}

std::string PlotsHtml(const std::vector<std::filesystem::path>& plots) {
  if (plots.empty()) return {};
  std::string html = "<h2>The whole run, joint by joint</h2>\n";
  for (const std::filesystem::path& plot : plots) {
    const std::string name = plot.stem().string();
    html += fmt::format("<details><summary>{}</summary>\n{}</details>\n", Escape(name),
                        report::InlineSvg(ReadFile(plot), name));
  }
  return html;
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
  const bool succeeded = Succeeded(task_result, evaluation);
  std::string body =
      fmt::format("<h1>{}</h1>\n<p>{}</p>\n", Escape(scenario.name), Escape(scenario.description));
  body += succeeded ? std::string("<p class=\"met\">succeeded</p>\n")
                    : fmt::format("<p class=\"failed\">failed: {}</p>\n",
                                  Escape(FailureOf(task_result, evaluation)));
  if (facts.has_video) body += "<video controls src=\"video.mp4\"></video>\n";
  body += FindingsHtml(evaluation.findings);
  body += StepsHtml(task_result.task);
  body += SnapshotsHtml(task_result, facts);
  body += FiguresHtml(evaluation.figures);
  body += PlotsHtml(facts.plots);
  body += report::FactsTable(facts.lines);
  return report::HtmlPage(scenario.name, body);
}

}  // namespace twin::application
