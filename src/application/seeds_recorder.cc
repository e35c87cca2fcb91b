#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "application/monte_carlo.h"
#include "twin/application/record_run.h"
#include "twin/core/clock.h"
#include "twin/core/error.h"
#include "twin/core/hash.h"
#include "twin/core/text.h"
#include "twin/report/page.h"
#include "twin/report/plot.h"
#include "twin/run/result_folder.h"
#include "twin/run/summary.h"

namespace twin::application {
namespace {

using Json = nlohmann::ordered_json;

Json FailuresJson(const MonteCarloResult& result) {
  Json failures = Json::array();
  for (const SeedOutcome& outcome : result.outcomes) {
    if (outcome.succeeded) continue;
    failures.push_back(
        {{"seed", outcome.seed}, {"step", outcome.failed_step}, {"failure", outcome.failure}});
  }
  return failures;
}

Json SpreadsJson(const std::vector<FindingSpread>& spreads) {
  Json findings = Json::array();
  for (const FindingSpread& spread : spreads) {
    findings.push_back({{"quantity", spread.quantity},
                        {"unit", spread.unit},
                        {"demand", spread.demand},
                        {"median", spread.median},
                        {"largest", spread.largest},
                        {"of_seed", spread.largest_seed},
                        {"missed", spread.missed}});
  }
  return findings;
}

std::string SeedsSummaryJson(const scenario::Scenario& scenario, const MonteCarloResult& result,
                             double least_percent) {
  return run::TextOf({{"scenario", scenario.name},
                      {"application", scenario.application->type},
                      {"first_seed", scenario.seed},
                      {"seeds", result.outcomes.size()},
                      {"version", TWIN_VERSION},
                      {"succeeded", result.succeeded},
                      {"share_percent", 100 * result.share()},
                      {"least_share_percent", 100 * result.least_share},
                      {"most_share_percent", 100 * result.most_share},
                      {"wanted_share_percent", least_percent},
                      {"failures", FailuresJson(result)},
                      {"findings", SpreadsJson(result.Spreads())},
                      {"libm", FormatHash(LibmFingerprint())}});
}

/// Adds the counts of a finding's values in bins of equal width.
void AddHistogram(const MonteCarloResult& result, const FindingSpread& spread,
                  report::Figure& figure) {
  constexpr std::size_t kBins = 20;
  std::vector<double> values;
  for (const SeedOutcome& outcome : result.outcomes) {
    const Finding* finding = outcome.Find(spread.quantity);
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

/// Of each finding with a demand that varies from seed to seed; an SVG element, or empty.
std::string HistogramsOf(const MonteCarloResult& result,
                         const std::vector<FindingSpread>& spreads) {
  report::Figure figure{.id = "histograms", .columns = "panel,centre,width,runs"};
  for (const FindingSpread& spread : spreads) {
    const bool varies = std::ranges::any_of(result.outcomes, [&](const SeedOutcome& outcome) {
      const Finding* finding = outcome.Find(spread.quantity);
      return finding != nullptr && finding->value != spread.median;
    });
    if (!spread.demand.empty() && varies) AddHistogram(result, spread, figure);
  }
  if (figure.rows.empty()) return {};
  return report::InlineSvg(report::DrawPlot("application/", figure), figure.id);
}

/// The report of many seeds: success rate, statistics of all findings, failures with their causes,
/// histograms. One HTML file that holds everything. @param facts  "lab": "a"; as a table.
std::string SeedsPage(const scenario::Scenario& scenario, const MonteCarloResult& result,
                      const std::vector<std::pair<std::string, std::string>>& facts) {
  const std::vector<FindingSpread> spreads = result.Spreads();
  const std::size_t runs = result.outcomes.size();
  const bool succeeded = result.succeeded == static_cast<int>(runs);
  const auto percent = [](double share) { return fmt::format("{:.1f}", 100 * share); };
  Json failures = FailuresJson(result);
  for (Json& failure : failures) {
    if (failure["step"] == "") failure["step"] = "evaluation";
  }
  Json findings = SpreadsJson(spreads);
  for (Json& finding : findings) {
    finding["verdict"] = finding["missed"] == 0 ? "met" : "missed";
    if (finding["demand"] == "") finding["missed"] = nullptr;
  }
  return report::RenderPage("application/seeds", {{"title", scenario.name},
                                                  {"description", scenario.description},
                                                  {"succeeded", result.succeeded},
                                                  {"runs", runs},
                                                  {"verdict", succeeded ? "met" : "failed"},
                                                  {"share", percent(result.share())},
                                                  {"least", percent(result.least_share)},
                                                  {"most", percent(result.most_share)},
                                                  {"failed", !succeeded},
                                                  {"failures", failures},
                                                  {"findings", findings},
                                                  {"histograms", HistogramsOf(result, spreads)},
                                                  {"facts", report::FactsOf(facts)}});
}

/// A row per seed with a column per finding. RFC 4180, with a header.
std::string SeedsCsv(const MonteCarloResult& result) {
  const std::vector<FindingSpread> spreads = result.Spreads();
  std::string csv = "seed,outcome,step,failure,repeated,duration_s,states_hash";
  for (const FindingSpread& spread : spreads) {
    csv +=
        ',' + CsvField(spread.unit.empty() ? spread.quantity
                                           : fmt::format("{} [{}]", spread.quantity, spread.unit));
  }
  csv += "\r\n";
  for (const SeedOutcome& outcome : result.outcomes) {
    csv += fmt::format("{},{},{},{},{},{:.3f},{}", outcome.seed,
                       outcome.succeeded ? "success" : "failed", CsvField(outcome.failed_step),
                       CsvField(outcome.failure), outcome.repeated, ToSeconds(outcome.duration),
                       FormatHash(outcome.states_hash));
    for (const FindingSpread& spread : spreads) {
      const Finding* finding = outcome.Find(spread.quantity);
      csv += finding == nullptr ? "," : fmt::format(",{:.6g}", finding->value);
    }
    csv += "\r\n";
  }
  return csv;
}

MonteCarloResult RunAllSeeds(const RunInputs& inputs, const SeedsOptions& options) {
  const MonotonicClock clock;
  int done = 0;
  int failed = 0;
  const auto on_outcome = [&](const SeedOutcome& outcome) {
    ++done;
    if (!outcome.succeeded) {
      ++failed;
      inputs.console.Note(fmt::format("seed {}: {}", outcome.seed, outcome.failure));
    }
    inputs.console.Show("seeds", static_cast<double>(done) / options.seeds,
                        fmt::format("{} of {}, {} failed", done, options.seeds, failed));
  };
  return RunSeeds(inputs.scenario, inputs.catalogue, inputs.files, clock,
                  {.first_seed = inputs.scenario.seed,
                   .seeds = options.seeds,
                   .threads = options.threads,
                   .interrupted = &inputs.console.interrupted()},
                  on_outcome);
}

}  // namespace

void RecordSeeds(const RunInputs& inputs, const SeedsOptions& options) {
  const scenario::Scenario& scenario = inputs.scenario;
  run::ResultFolder out(inputs.options.out);
  out.RequireOther(inputs.options.scenario);
  out.Prepare();
  out.Clear();
  const MonteCarloResult result = RunAllSeeds(inputs, options);
  inputs.console.ThrowIfInterrupted();
  run::WriteWholeFile(out.scenario(), scenario::ToYaml(scenario));
  run::WriteWholeFile(out.seeds(), SeedsCsv(result));
  run::WriteWholeFile(out.summary(), SeedsSummaryJson(scenario, result, options.least_percent));
  const std::uint64_t last = scenario.seed + static_cast<std::uint64_t>(options.seeds) - 1;
  run::WriteWholeFile(out.report(),
                      SeedsPage(scenario, result,
                                {{"application", scenario.application->type},
                                 {"seeds", fmt::format("{} to {}", scenario.seed, last)},
                                 {"site", inputs.options.site},
                                 {"panda-twin", TWIN_VERSION}}));
  const std::string text = fmt::format(
      "{} of {} seeds succeeded: {:.1f} % (between {:.1f} and {:.1f} % by 95 % confidence)",
      result.succeeded, result.outcomes.size(), 100 * result.share(), 100 * result.least_share,
      100 * result.most_share);
  inputs.console.Print(
      fmt::format("{}: {}\n  files  {}\n", scenario.name, text, out.folder().string()));
  if (100 * result.share() >= options.least_percent) return;
  throw RobotFault(fmt::format("{}; wanted are at least {} %, see {}", text, options.least_percent,
                               out.report().string()));
}

}  // namespace twin::application
