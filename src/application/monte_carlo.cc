#include "application/monte_carlo.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <mutex>
#include <optional>
#include <thread>
#include <tuple>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "twin/core/error.h"
#include "twin/core/hash.h"
#include "twin/core/proportion.h"
#include "twin/core/text.h"
#include "twin/record/cycle_record.h"
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
    if (outcome.succeeded()) continue;
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
void AddHistogram(const FindingSpread& spread, report::Figure& figure) {
  constexpr std::size_t kBins = 20;
  std::vector<double> values = spread.values;
  std::erase_if(values, [](double value) { return !std::isfinite(value); });
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
std::string HistogramsOf(const std::vector<FindingSpread>& spreads) {
  report::Figure figure{.id = "histograms", .columns = "panel,centre,width,runs"};
  for (const FindingSpread& spread : spreads) {
    const bool varies =
        std::ranges::any_of(spread.values, [&](double value) { return value != spread.median; });
    if (!spread.demand.empty() && varies) AddHistogram(spread, figure);
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
    for (const char* key : {"median", "largest"}) {
      finding[key] = RoundedText(finding[key], finding["unit"].get<std::string>());
    }
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
                                                  {"histograms", HistogramsOf(spreads)},
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
                       outcome.succeeded() ? "success" : "failed", CsvField(outcome.failed_step),
                       CsvField(outcome.failure), outcome.repeated, ToSeconds(outcome.duration),
                       FormatHash(outcome.states_hash));
    for (const FindingSpread& spread : spreads) {
      const auto finding = std::ranges::find(outcome.findings, spread.quantity, &Finding::quantity);
      csv += finding == outcome.findings.end() ? "," : fmt::format(",{:.6g}", finding->value);
    }
    csv += "\r\n";
  }
  return csv;
}

}  // namespace

std::vector<FindingSpread> MonteCarloResult::Spreads() const {
  std::vector<FindingSpread> spreads;
  for (const SeedOutcome& outcome : outcomes) {
    for (const Finding& finding : outcome.findings) {
      auto spread = std::ranges::find(spreads, finding.quantity, &FindingSpread::quantity);
      if (spread == spreads.end()) {
        spreads.push_back({.quantity = finding.quantity,
                           .unit = finding.unit,
                           .demand = finding.demand,
                           .largest = finding.value,
                           .largest_seed = outcome.seed});
        spread = spreads.end() - 1;
      }
      spread->values.push_back(finding.value);
      spread->missed += finding.met == false ? 1 : 0;
      if (finding.value <= spread->largest) continue;
      spread->largest = finding.value;
      spread->largest_seed = outcome.seed;
    }
  }
  for (FindingSpread& spread : spreads) {
    std::vector<double> values = spread.values;
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::ranges::nth_element(values, middle);
    spread.median = *middle;
  }
  return spreads;
}

MonteCarloResult RunSeeds(const scenario::Scenario& scenario, const run::Catalogue& catalogue,
                          const run::RunFiles& files, const SeedsOptions& options,
                          const std::function<void(const SeedOutcome&)>& on_outcome,
                          const volatile bool* interrupted) {
  RequireInRange("seeds", options.seeds, 1, 100'000);
  RequireInRange("threads", options.threads, 1, 64);
  if (!scenario.is_lockstep()) {
    throw InputError("seeds: runs of many seeds take drive: lockstep");
  }
  const auto is_interrupted = [&] { return interrupted != nullptr && *interrupted; };
  const auto seed_of = [&](int k) { return scenario.seed + static_cast<std::uint64_t>(k); };
  const auto run = [&](int k) {
    return RunSeed(scenario, seed_of(k), catalogue, files, interrupted);
  };
  std::mutex mutex;
  std::vector<std::optional<SeedOutcome>> outcomes(static_cast<std::size_t>(options.seeds));
  const auto keep = [&](int k, SeedOutcome outcome) {
    const std::scoped_lock lock(mutex);
    if (on_outcome) on_outcome(outcome);
    outcomes[static_cast<std::size_t>(k)] = std::move(outcome);
  };
  // The first run compiles the model for the cache, and throws what makes every run impossible.
  keep(0, run(0));
  std::atomic<int> next{1};
  const auto work = [&] {
    for (int k = next++; k < options.seeds && !is_interrupted(); k = next++) {
      SeedOutcome outcome;
      try {
        outcome = run(k);
      } catch (const Error& error) {
        outcome = {.seed = seed_of(k), .failure = error.what()};
      }
      if (!is_interrupted()) keep(k, std::move(outcome));  // else the run is not complete
    }
  };
  std::vector<std::jthread> workers(
      static_cast<std::size_t>(std::min(options.threads, options.seeds)));
  for (std::jthread& worker : workers) worker = std::jthread(work);
  workers.clear();
  MonteCarloResult result;
  for (std::optional<SeedOutcome>& outcome : outcomes) {
    if (!outcome) continue;
    result.succeeded += outcome->succeeded() ? 1 : 0;
    result.outcomes.push_back(std::move(*outcome));
  }
  std::tie(result.least_share, result.most_share) =
      WilsonInterval(result.succeeded, static_cast<int>(result.outcomes.size()));
  return result;
}

void RecordSeeds(const RunInputs& inputs, const SeedsOptions& options) {
  const scenario::Scenario& scenario = inputs.scenario;
  run::ResultFolder out(inputs.options.out);
  out.RequireOther(inputs.options.scenario);
  out.Prepare();
  out.Clear();
  int done = 0;
  int failed = 0;
  const auto on_outcome = [&](const SeedOutcome& outcome) {
    ++done;
    if (!outcome.succeeded()) {
      ++failed;
      inputs.console.Note(fmt::format("seed {}: {}", outcome.seed, outcome.failure));
    }
    inputs.console.Show("seeds", static_cast<double>(done) / options.seeds,
                        fmt::format("{} of {}, {} failed", done, options.seeds, failed));
  };
  const MonteCarloResult result = RunSeeds(scenario, inputs.catalogue, inputs.files, options,
                                           on_outcome, &inputs.console.interrupted());
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
