#include "twin/experiment/page.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "twin/report/page.h"
#include "twin/run/summary.h"

namespace twin::experiment {
namespace {

using nlohmann::json;

std::string Number(double value) {
  return std::isfinite(value) ? fmt::format("{:.4g}", value) : std::string("none");
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

/// CSS class in the colour of a verdict.
std::string_view ClassOf(Verdict verdict) {
  if (verdict == Verdict::kPredicted) return "met";
  return verdict == Verdict::kNotReproduced ? "missed" : "reported";
}

/// CSS class in the colour of an outcome.
std::string_view ClassOf(const Findings& findings) {
  if (!findings.failure.empty()) return "failed";
  if (!findings.succeeded()) return "missed";
  return Count(findings, Verdict::kPredicted) > 0 ? "met" : "reported";
}

/// A number, or null.
json NumberOrNull(const std::optional<double>& value) {
  return value ? json(*value) : json();
}

nlohmann::ordered_json JsonOf(const Comparison& comparison) {
  return {{"quantity", comparison.quantity},
          {"unit", comparison.unit},
          {"paper", NumberOrNull(comparison.paper)},
          {"ours", comparison.ours},
          {"low", NumberOrNull(comparison.low)},
          {"high", NumberOrNull(comparison.high)},
          {"demand", comparison.demand},
          {"verdict", Name(comparison.verdict)},
          {"reason", comparison.reason}};
}

json ComparisonsOf(const Findings& findings) {
  json list = json::array();
  for (const Comparison& comparison : findings.comparisons) {
    json& one = list.emplace_back(JsonOf(comparison));
    one["ratio"] = NumberOrNull(comparison.ratio());
    one["spread"] = SpreadText(comparison);
    one["class"] = ClassOf(comparison.verdict);
    if (comparison.verdict == Verdict::kNotReproduced && !comparison.reason.empty()) {
      one["demand"] = fmt::format("{}; {}", comparison.demand, comparison.reason);
    }
  }
  return list;
}

json FiguresOf(const Findings& findings) {
  json figures = json::object();
  for (const Figure& figure : findings.figures) {
    const std::string name = fmt::format("{}_{}", findings.id, figure.id);
    json& one = figures[figure.id] = figure.values;
    one["id"] = figure.id;
    one["csv"] = CsvName(findings, figure);
    one["svg"] = report::InlineSvg(
        report::DrawPlot(fmt::format("experiment/{}_", findings.id), figure), name);
  }
  return figures;
}

/// The section of an experiment.
json SectionOf(const Findings& findings) {
  json section{
      {"id", findings.id},          {"title", findings.title},      {"source", findings.source},
      {"class", ClassOf(findings)}, {"outcome", Outcome(findings)}, {"failure", findings.failure}};
  if (!findings.failure.empty() || findings.page.empty()) return section;
  json data = findings.values;
  data["compared"] = !findings.comparisons.empty();
  data["comparisons"] = ComparisonsOf(findings);
  data["figures"] = FiguresOf(findings);
  section["body"] = report::RenderPage("experiment/" + findings.page, data);
  return section;
}

constexpr std::string_view kTitle = "The paper beside its digital twin";

json FactsOf(const PageFacts& facts) {
  std::vector<std::pair<std::string, std::string>> lines{
      {"seed", fmt::format("{}", facts.seed)},
      {"runs averaged", fmt::format("{}", facts.seeds)},
      {"calibration", facts.calibration.empty() ? "unreadable" : facts.calibration},
      {"panda-twin", facts.version}};
  if (!facts.machine.empty()) lines.emplace_back("machine", facts.machine);
  return report::FactsOf(lines);
}

}  // namespace

std::string Page(std::span<const Findings> findings, const PageFacts& facts) {
  json experiments = json::array();
  for (const Findings& one : findings) experiments.push_back(SectionOf(one));
  return report::RenderPage("experiment/report", {{"title", kTitle},
                                                  {"wall_clock", !facts.machine.empty()},
                                                  {"left_out", facts.left_out},
                                                  {"experiments", std::move(experiments)},
                                                  {"facts", FactsOf(facts)},
                                                  {"parameters", facts.parameters}});
}

bool IsPage(std::string_view html) {
  return html.find(fmt::format("<title>{}</title>", kTitle)) != std::string_view::npos;
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

std::string FindingsJson(std::span<const Findings> findings, int seeds,
                         std::string_view calibration) {
  using Json = nlohmann::ordered_json;
  Json experiments = Json::array();
  for (const Findings& one : findings) {
    Json comparisons = Json::array();
    for (const Comparison& comparison : one.comparisons) comparisons.push_back(JsonOf(comparison));
    experiments.push_back({{"id", one.id},
                           {"outcome", Outcome(one)},
                           {"failure", one.failure},
                           {"comparisons", std::move(comparisons)}});
  }
  return run::TextOf(
      {{"seeds", seeds}, {"calibration", calibration}, {"experiments", std::move(experiments)}});
}

std::string CsvName(const Findings& findings, const Figure& figure) {
  return fmt::format("{}_{}.csv", findings.id, figure.id);
}

std::string Outcome(const Findings& findings) {
  if (!findings.failure.empty()) return "failed";
  const std::ptrdiff_t met = Count(findings, Verdict::kPredicted);
  const std::ptrdiff_t missed = Count(findings, Verdict::kNotReproduced);
  const std::ptrdiff_t calibrated = Count(findings, Verdict::kCalibrated);
  const std::ptrdiff_t of_the_paper =
      std::ranges::count_if(findings.comparisons, [](const Comparison& comparison) {
        return comparison.verdict == Verdict::kPredicted && comparison.paper.has_value();
      });
  std::string outcome =
      met + missed == 0 ? "nothing demanded"
                        : fmt::format("{} of {} demands met, {} of them on figures of the paper",
                                      met, met + missed, of_the_paper);
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
