#include <cstdint>
#include <string>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "twin/application/monte_carlo.h"
#include "twin/application/record_run.h"
#include "twin/application/seeds_page.h"
#include "twin/core/clock.h"
#include "twin/core/error.h"
#include "twin/core/fingerprint.h"
#include "twin/run/result_folder.h"
#include "twin/run/summary.h"

namespace twin::application {
namespace {

using Json = nlohmann::ordered_json;

std::string SummaryJson(const scenario::Scenario& scenario, const MonteCarloResult& result,
                        double least_percent) {
  Json failures = Json::array();
  for (const SeedOutcome& outcome : result.outcomes) {
    if (outcome.succeeded) continue;
    failures.push_back(
        {{"seed", outcome.seed}, {"step", outcome.failed_step}, {"failure", outcome.failure}});
  }
  Json findings = Json::array();
  for (const FindingSpread& spread : result.Spreads()) {
    findings.push_back({{"quantity", spread.quantity},
                        {"unit", spread.unit},
                        {"demand", spread.demand},
                        {"median", spread.median},
                        {"largest", spread.largest},
                        {"of_seed", spread.largest_seed},
                        {"missed", spread.missed}});
  }
  const Json summary{{"scenario", scenario.name},
                     {"application", scenario.application->type},
                     {"first_seed", scenario.seed},
                     {"seeds", result.outcomes.size()},
                     {"version", TWIN_VERSION},
                     {"succeeded", result.succeeded},
                     {"share_percent", 100 * result.share()},
                     {"least_share_percent", 100 * result.least_share},
                     {"most_share_percent", 100 * result.most_share},
                     {"wanted_share_percent", least_percent},
                     {"failures", failures},
                     {"findings", findings},
                     {"libm", FormatHash(LibmFingerprint())}};
  return run::TextOf(summary);
}

MonteCarloResult RunAll(const scenario::Scenario& scenario, const SeedsOptions& seeds,
                        const run::RunFiles& files, const run::Catalogue& catalogue,
                        run::Console& console) {
  const MonotonicClock clock;
  int done = 0;
  int failed = 0;
  const auto told = [&](const SeedOutcome& outcome) {
    ++done;
    if (!outcome.succeeded) {
      ++failed;
      console.Note(fmt::format("seed {}: {}", outcome.seed, outcome.failure));
    }
    console.Show("seeds", static_cast<double>(done) / seeds.seeds,
                 fmt::format("{} of {}, {} failed", done, seeds.seeds, failed));
  };
  return RunSeeds(scenario, catalogue, files, clock,
                  {.first_seed = scenario.seed,
                   .seeds = seeds.seeds,
                   .threads = seeds.threads,
                   .interrupted = &console.interrupted()},
                  told);
}

}  // namespace

void RecordSeeds(const scenario::Scenario& scenario, const RunOptions& options,
                 const SeedsOptions& seeds, const run::RunFiles& files,
                 const run::Catalogue& catalogue, run::Console& console) {
  run::ResultFolder out(options.out);
  out.Prepare();
  out.Clear();
  const MonteCarloResult result = RunAll(scenario, seeds, files, catalogue, console);
  console.ThrowIfInterrupted();
  run::WriteWholeFile(out.scenario(), scenario::ToYaml(scenario));
  run::WriteWholeFile(out.seeds(), SeedsCsv(result));
  run::WriteWholeFile(out.summary(), SummaryJson(scenario, result, seeds.least_percent));
  const std::uint64_t last = scenario.seed + static_cast<std::uint64_t>(seeds.seeds) - 1;
  run::WriteWholeFile(out.report(),
                      SeedsPage(scenario, result,
                                {{"application", scenario.application->type},
                                 {"seeds", fmt::format("{} to {}", scenario.seed, last)},
                                 {"site", options.site},
                                 {"panda-twin", TWIN_VERSION}}));
  const std::string text = fmt::format(
      "{} of {} seeds succeeded: {:.1f} % (between {:.1f} and {:.1f} % by 95 % confidence)",
      result.succeeded, result.outcomes.size(), 100 * result.share(), 100 * result.least_share,
      100 * result.most_share);
  console.Print(fmt::format("{}: {}\n  files  {}\n", scenario.name, text, out.folder().string()));
  if (100 * result.share() >= seeds.least_percent) return;
  throw RobotFault(fmt::format("{}; wanted are at least {} %, see {}", text, seeds.least_percent,
                               out.report().string()));
}

}  // namespace twin::application
