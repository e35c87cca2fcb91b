#include "twin/application/seeds_page.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "twin/core/fingerprint.h"
#include "twin/report/page.h"
#include "twin/report/plot.h"

namespace twin::application {
namespace {

using nlohmann::json;

/// The finding of these words; null when a run has none.
const Finding* Find(const SeedOutcome& outcome, const std::string& quantity) {
  const auto found = std::ranges::find(outcome.findings, quantity, &Finding::quantity);
  return found == outcome.findings.end() ? nullptr : &*found;
}

json SpreadsOf(const std::vector<FindingSpread>& spreads) {
  json list = json::array();
  for (const FindingSpread& spread : spreads) {
    list.push_back({{"quantity", spread.quantity},
                    {"median", spread.median},
                    {"largest", spread.largest},
                    {"seed", spread.largest_seed},
                    {"unit", spread.unit},
                    {"demand", spread.demand},
                    {"verdict", spread.missed == 0 ? "met" : "missed"},
                    {"missed", spread.demand.empty() ? json() : json(spread.missed)}});
  }
  return list;
}

json FailuresOf(const MonteCarloResult& result) {
  json list = json::array();
  for (const SeedOutcome& outcome : result.outcomes) {
    if (outcome.succeeded) continue;
    list.push_back({{"seed", outcome.seed},
                    {"step", outcome.failed_step.empty() ? "evaluation" : outcome.failed_step},
                    {"cause", outcome.failure}});
  }
  return list;
}

/// Adds the counts of a finding's values in bins of equal width.
void AddHistogram(const MonteCarloResult& result, const FindingSpread& spread,
                  report::Figure& figure) {
  constexpr std::size_t kBins = 20;
  std::vector<double> values;
  for (const SeedOutcome& outcome : result.outcomes) {
    const Finding* finding = Find(outcome, spread.quantity);
    if (finding != nullptr && std::isfinite(finding->value)) values.push_back(finding->value);
  }
  if (values.empty()) return;
  figure.names.push_back(spread.quantity);
  figure.names.push_back(spread.unit.empty() ? "" : fmt::format("[{}]", spread.unit));
  const auto [least, most] = std::ranges::minmax(values);
  const double width = most > least ? (most - least) / kBins : 1;
  std::array<double, kBins> counts{};
  for (const double value : values) {
    ++counts.at(std::min(kBins - 1, static_cast<std::size_t>((value - least) / width)));
  }
  for (std::size_t i = 0; i < kBins; ++i) {
    figure.rows.push_back({static_cast<double>(figure.names.size()) / 2,
                           least + width * (static_cast<double>(i) + 0.5), width, counts.at(i)});
  }
}

std::string HistogramsOf(const MonteCarloResult& result,
                         const std::vector<FindingSpread>& spreads) {
  report::Figure figure{.id = "histograms", .columns = "panel,centre,width,runs"};
  for (const FindingSpread& spread : spreads) {
    const bool varies = std::ranges::any_of(result.outcomes, [&](const SeedOutcome& outcome) {
      const Finding* finding = Find(outcome, spread.quantity);
      return finding != nullptr && finding->value != spread.median;
    });
    if (!spread.demand.empty() && varies) AddHistogram(result, spread, figure);
  }
  if (figure.rows.empty()) return {};
  return report::InlineSvg(report::DrawPlot("application/", figure), figure.id);
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
  const bool succeeded = result.succeeded == static_cast<int>(runs);
  const auto percent = [](double share) { return fmt::format("{:.1f}", 100 * share); };
  return report::RenderPage("application/seeds", {{"title", scenario.name},
                                                  {"description", scenario.description},
                                                  {"succeeded", result.succeeded},
                                                  {"runs", runs},
                                                  {"verdict", succeeded ? "met" : "failed"},
                                                  {"share", percent(result.share())},
                                                  {"least", percent(result.least_share)},
                                                  {"most", percent(result.most_share)},
                                                  {"failed", !succeeded},
                                                  {"failures", FailuresOf(result)},
                                                  {"spreads", SpreadsOf(spreads)},
                                                  {"histograms", HistogramsOf(result, spreads)},
                                                  {"facts", report::FactsOf(facts)}});
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
