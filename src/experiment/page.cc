#include "twin/experiment/page.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "twin/report/html.h"

namespace twin::experiment {
namespace {

using report::Escape;

std::string Number(double value) {
  return std::isfinite(value) ? fmt::format("{:.4g}", value) : std::string("none");
}

std::string Number(const std::optional<double>& value) {
  return value ? Number(*value) : std::string();
}

std::string WithUnit(double value, const std::string& unit) {
  return unit.empty() ? Number(value) : fmt::format("{} {}", Number(value), unit);
}

std::string SpreadText(const Comparison& comparison) {
  if (!comparison.low || !comparison.high) return {};
  return fmt::format("{} … {}", Number(*comparison.low), Number(*comparison.high));
}

std::ptrdiff_t Count(const Findings& findings, Verdict verdict) {
  return std::ranges::count(findings.comparisons, verdict, &Comparison::verdict);
}

/// Class of what is shown in the colour of a verdict.
std::string_view ClassOf(Verdict verdict) {
  if (verdict == Verdict::kPredicted) return "met";
  return verdict == Verdict::kNotReproduced ? "missed" : "reported";
}

/// The same of an outcome.
std::string_view ClassOf(const Findings& findings) {
  if (!findings.failure.empty()) return "failed";
  if (!findings.succeeded()) return "missed";
  return Count(findings, Verdict::kPredicted) > 0 ? "met" : "reported";
}

std::string SummaryTable(std::span<const Findings> all) {
  std::string html = "<table>\n<tr><th>experiment</th><th>in the paper</th><th>outcome</th></tr>\n";
  for (const Findings& findings : all) {
    html += fmt::format(
        "<tr><td><a href=\"#{}\">{}</a></td><td class=\"word\">{}</td><td "
        "class=\"{}\">{}</td></tr>\n",
        Escape(findings.id), Escape(findings.title), Escape(findings.source), ClassOf(findings),
        Escape(Outcome(findings)));
  }
  return html + "</table>\n";
}

std::string ComparisonTable(const Findings& findings) {
  if (findings.comparisons.empty()) return {};
  std::string html =
      "<div class=\"wide\"><table>\n<tr><th>quantity</th><th>unit</th><th>paper</th><th>ours</th>"
      "<th>ratio</th><th>lowest … highest run</th><th>demanded</th><th>verdict</th></tr>\n";
  for (const Comparison& comparison : findings.comparisons) {
    const bool has_reason =
        comparison.verdict == Verdict::kNotReproduced && !comparison.reason.empty();
    const std::string demand = has_reason
                                   ? fmt::format("{}; {}", comparison.demand, comparison.reason)
                                   : comparison.demand;
    html += fmt::format(
        "<tr><td>{}</td><td class=\"word\">{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td "
        "class=\"word\">{}</td><td class=\"{}\">{}</td></tr>\n",
        Escape(comparison.quantity), Escape(comparison.unit), Number(comparison.paper),
        Number(comparison.ours), Number(comparison.ratio()), SpreadText(comparison), Escape(demand),
        ClassOf(comparison.verdict), Name(comparison.verdict));
  }
  return html + "</table></div>\n";
}

std::string FigureHtml(const Findings& findings, const Figure& figure) {
  const std::string csv = CsvName(findings, figure);
  return fmt::format(
      "<h3>{}</h3>\n<figure>\n<figcaption>{} <a "
      "href=\"csv/{}\">CSV</a></figcaption>\n{}</figure>\n",
      Escape(figure.title), Escape(figure.what), Escape(csv),
      report::InlineSvg(figure.svg, fmt::format("{}_{}", findings.id, figure.id)));
}

std::string Section(const Findings& findings) {
  std::string html =
      fmt::format("<h2 id=\"{}\">{}</h2>\n<p class=\"run\">{}</p>\n", Escape(findings.id),
                  Escape(findings.title), Escape(findings.source));
  if (!findings.failure.empty()) {
    html += fmt::format("<p class=\"failed\">failed: {}</p>\n", Escape(findings.failure));
  }
  if (!findings.text.empty()) html += fmt::format("<p>{}</p>\n", Escape(findings.text));
  html += ComparisonTable(findings);
  for (const Figure& figure : findings.figures) html += FigureHtml(findings, figure);
  return html;
}

std::string Lines(std::string_view text) {
  std::string html;
  while (!text.empty()) {
    const std::string_view line = text.substr(0, text.find('\n'));
    text.remove_prefix(std::min(text.size(), line.size() + 1));
    html += Escape(line) + "\n";
  }
  return html;
}

constexpr std::string_view kTitle = "The paper beside its digital twin";

std::string FactsHtml(const PageFacts& facts) {
  std::vector<std::pair<std::string, std::string>> lines{
      {"seed of everything", fmt::format("{}", facts.seed)},
      {"runs of what is averaged", fmt::format("{}", facts.seeds)},
      {"calibration", facts.calibration.empty() ? "could not be read" : facts.calibration},
      {"panda-twin", facts.version}};
  if (!facts.machine.empty()) lines.emplace_back("machine", facts.machine);
  std::string html = report::FactsTable(lines);
  if (!facts.parameters.empty()) {
    html += "<details><summary>The calibrated loops</summary>\n<pre>" + Lines(facts.parameters) +
            "</pre></details>\n";
  }
  return html;
}

}  // namespace

std::string Page(std::span<const Findings> findings, const PageFacts& facts) {
  std::string html = fmt::format(
      "<h1>{}</h1>\n<p class=\"run\">Keeping the Franka Emika Panda alive: a ROS 2 stack with a "
      "reliable position interface (Langella, Risi, Petrone, Ferrentino, Chiacchio), reproduced "
      "{}. "
      "LF: bare libfranka; RS: synchronous ROS 2 stack; RA: asynchronous ROS 2 stack. Predicted: "
      "follows by mechanism from what was not fitted to it, within what is demanded; calibrated: "
      "an "
      "input, fitted to what stands beside it; not reproduced: is demanded and does not come "
      "out. Only the first counts as met.</p>\n",
      kTitle, facts.machine.empty() ? "in lockstep" : "on the wall clock, over UDP on one machine");
  if (!facts.left_out.empty()) html += fmt::format("<p>{}</p>\n", Escape(facts.left_out));
  html += SummaryTable(findings);
  for (const Findings& one : findings) html += Section(one);
  return report::HtmlPage(kTitle, html + FactsHtml(facts));
}

bool IsPage(std::string_view html) {
  return html.find(fmt::format("<h1>{}</h1>", kTitle)) != std::string_view::npos;
}

std::vector<std::string> CsvNamesOf(std::string_view html) {
  constexpr std::string_view kBefore = "href=\"csv/";
  std::vector<std::string> names;
  for (std::size_t at = html.find(kBefore); at != std::string_view::npos;
       at = html.find(kBefore, at + 1)) {
    const std::string_view rest = html.substr(at + kBefore.size());
    const std::string_view name = rest.substr(0, rest.find('"'));
    if (name.ends_with(".csv") && name.find('/') == std::string_view::npos) {
      names.emplace_back(name);
    }
  }
  return names;
}

std::string Csv(const Figure& figure) {
  std::string csv = figure.columns + "\n";
  for (const auto& row : figure.rows) {
    for (std::size_t i = 0; i < row.size(); ++i) {
      if (i > 0) csv += ',';
      if (std::isfinite(row[i])) csv += fmt::format("{:.9g}", row[i]);
    }
    csv += '\n';
  }
  return csv;
}

std::string CsvName(const Findings& findings, const Figure& figure) {
  return fmt::format("{}_{}.csv", findings.id, figure.id);
}

std::string Outcome(const Findings& findings) {
  if (!findings.failure.empty()) return "failed";
  const std::ptrdiff_t met = Count(findings, Verdict::kPredicted);
  const std::ptrdiff_t missed = Count(findings, Verdict::kNotReproduced);
  const std::ptrdiff_t calibrated = Count(findings, Verdict::kCalibrated);
  std::string outcome = met + missed == 0 ? "nothing demanded"
                                          : fmt::format("{} of {} demands met", met, met + missed);
  if (missed > 0) outcome += fmt::format("; {} not reproduced", missed);
  if (calibrated > 0) outcome += fmt::format("; {} calibrated", calibrated);
  return outcome;
}

std::string MissedLines(const Findings& findings) {
  std::string lines;
  for (const Comparison& comparison : findings.comparisons) {
    if (!comparison.is_missed()) continue;
    lines += fmt::format("{}: {}", comparison.quantity, WithUnit(comparison.ours, comparison.unit));
    if (comparison.paper) {
      lines += fmt::format("; the paper's is {}", WithUnit(*comparison.paper, comparison.unit));
    }
    lines += fmt::format("; demanded: {}\n", comparison.demand);
  }
  return lines;
}

}  // namespace twin::experiment
