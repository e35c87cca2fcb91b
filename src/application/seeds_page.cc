#include "twin/application/seeds_page.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include <fmt/format.h>

#include "twin/core/fingerprint.h"
#include "twin/report/chart.h"
#include "twin/report/html.h"

namespace twin::application {
namespace {

using report::Escape;

/// The finding of these words; null when a run has none.
const Finding* Find(const SeedOutcome& outcome, const std::string& quantity) {
  const auto found = std::ranges::find(outcome.findings, quantity, &Finding::quantity);
  return found == outcome.findings.end() ? nullptr : &*found;
}

std::string SpreadsHtml(const std::vector<FindingSpread>& spreads) {
  std::string html =
      "<h2>What came of it</h2>\n<div class=\"wide\"><table>\n<tr><th>quantity</th><th>median</th>"
      "<th>largest</th><th>of seed</th><th>unit</th><th>demanded</th><th>missed</th></tr>\n";
  for (const FindingSpread& spread : spreads) {
    html += fmt::format(
        "<tr><td>{}</td><td>{:.4g}</td><td>{:.4g}</td><td>{}</td><td class=\"word\">{}</td>"
        "<td class=\"word\">{}</td><td class=\"{}\">{}</td></tr>\n",
        Escape(spread.quantity), spread.median, spread.largest, spread.largest_seed,
        Escape(spread.unit), Escape(spread.demand), spread.missed == 0 ? "met" : "missed",
        spread.demand.empty() ? "" : fmt::format("{}", spread.missed));
  }
  return html + "</table></div>\n";
}

std::string FailuresHtml(const MonteCarloResult& result) {
  if (result.succeeded == static_cast<int>(result.outcomes.size())) return {};
  std::string html =
      "<h2>What failed</h2>\n<div class=\"wide\"><table>\n<tr><th>seed</th><th>step</th><th>why"
      "</th></tr>\n";
  for (const SeedOutcome& outcome : result.outcomes) {
    if (outcome.succeeded) continue;
    html += fmt::format(
        "<tr><td>{}</td><td class=\"word\">{}</td><td class=\"word\">{}</td></tr>\n", outcome.seed,
        outcome.failed_step.empty() ? "evaluation" : Escape(outcome.failed_step),
        Escape(outcome.failure));
  }
  return html + "</table></div>\n";
}

/// Counts of the values in bins of equal width.
report::ChartPanel HistogramOf(const MonteCarloResult& result, const FindingSpread& spread) {
  constexpr std::size_t kBins = 20;
  std::vector<double> values;
  for (const SeedOutcome& outcome : result.outcomes) {
    const Finding* finding = Find(outcome, spread.quantity);
    if (finding != nullptr && std::isfinite(finding->value)) values.push_back(finding->value);
  }
  report::ChartPanel panel;
  panel.title = spread.quantity;
  panel.x_label = spread.unit.empty() ? "" : fmt::format("[{}]", spread.unit);
  panel.y_label = "runs";
  const double least = std::ranges::min(values);
  const double most = std::ranges::max(values);
  const double width = most > least ? (most - least) / kBins : 1;
  report::ChartCurve bars{.style = report::ChartCurve::Style::kBars};
  for (std::size_t i = 0; i < kBins; ++i) {
    const double low = least + width * static_cast<double>(i);
    const auto in_bin = [&](double value) {
      const auto bin = std::min(kBins - 1, static_cast<std::size_t>((value - least) / width));
      return bin == i;
    };
    bars.x.push_back(low + width / 2);
    bars.y.push_back(static_cast<double>(std::ranges::count_if(values, in_bin)));
  }
  panel.curves = {bars};
  return panel;
}

std::string HistogramsHtml(const MonteCarloResult& result,
                           const std::vector<FindingSpread>& spreads) {
  report::Chart chart;
  chart.columns = 2;
  chart.panel_height = 220;
  for (const FindingSpread& spread : spreads) {
    const bool varies = std::ranges::any_of(result.outcomes, [&](const SeedOutcome& outcome) {
      const Finding* finding = Find(outcome, spread.quantity);
      return finding != nullptr && finding->value != spread.median;
    });
    if (!spread.demand.empty() && varies) chart.panels.push_back(HistogramOf(result, spread));
  }
  if (chart.panels.empty()) return {};
  return fmt::format("<h2>Over all runs</h2>\n<figure>\n{}</figure>\n",
                     report::InlineSvg(report::DrawChart(chart), "histograms"));
}

std::string CsvField(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"') quoted += '"';
    quoted += c;
  }
  return quoted + "\"";
}

}  // namespace

std::string SeedsPage(const scenario::Scenario& scenario, const MonteCarloResult& result,
                      const std::vector<std::pair<std::string, std::string>>& facts) {
  const std::vector<FindingSpread> spreads = result.Spreads();
  const std::size_t runs = result.outcomes.size();
  std::string body = fmt::format(
      "<h1>{}: {} of {} seeds</h1>\n<p>{}</p>\n<p class=\"{}\">{:.1f} % succeeded; between {:.1f} "
      "and {:.1f} % by 95 % confidence</p>\n",
      Escape(scenario.name), result.succeeded, runs, Escape(scenario.description),
      result.succeeded == static_cast<int>(runs) ? "met" : "failed", 100 * result.share(),
      100 * result.least_share, 100 * result.most_share);
  body += FailuresHtml(result);
  body += SpreadsHtml(spreads);
  body += HistogramsHtml(result, spreads);
  body += report::FactsTable(facts);
  body += "<p><a href=\"seeds.csv\">Every seed, as CSV</a></p>\n";
  return report::HtmlPage(scenario.name, body);
}

std::string SeedsCsv(const MonteCarloResult& result) {
  const std::vector<FindingSpread> spreads = result.Spreads();
  std::string csv = "seed,outcome,step,failure,repeated,duration_s,states_hash";
  for (const FindingSpread& spread : spreads) {
    csv += ',';
    csv += CsvField(spread.unit.empty() ? spread.quantity
                                        : fmt::format("{} [{}]", spread.quantity, spread.unit));
  }
  csv += "\r\n";
  for (const SeedOutcome& outcome : result.outcomes) {
    csv += fmt::format("{},{},{},{},{},{:.3f},{}", outcome.seed,
                       outcome.succeeded ? "success" : "failed", CsvField(outcome.failed_step),
                       CsvField(outcome.failure), outcome.repeated, ToSeconds(outcome.duration),
                       FormatHash(outcome.states_hash));
    for (const FindingSpread& spread : spreads) {
      const Finding* finding = Find(outcome, spread.quantity);
      csv += finding == nullptr ? "," : fmt::format(",{:.6g}", finding->value);
    }
    csv += "\r\n";
  }
  return csv;
}

}  // namespace twin::application
