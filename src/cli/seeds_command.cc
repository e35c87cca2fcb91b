#include "cli/seeds_command.h"

#include <cstdio>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "cli/host.h"
#include "cli/interrupt.h"
#include "cli/progress.h"
#include "cli/result_folder.h"
#include "cli/run_setup.h"
#include "cli/say.h"
#include "cli/summary.h"
#include "twin/application/monte_carlo.h"
#include "twin/application/seeds_page.h"
#include "twin/core/clock.h"
#include "twin/core/error.h"
#include "twin/core/fingerprint.h"

namespace twin::cli {
namespace {

using Json = nlohmann::ordered_json;

void RequireFlags(const scenario::Scenario& scenario, const RunFlags& flags) {
  if (!scenario.application) {
    throw InputError("--seeds goes with an application; this scenario has a motion");
  }
  if (scenario.drive != scenario::Drive::kLockstep) {
    throw InputError("--seeds goes with lockstep: on the wall clock no seed repeats");
  }
  if (flags.max_speed) throw InputError("--seeds and --max-speed do not go together");
  if (!(flags.least_share >= 0 && flags.least_share <= 100)) {
    throw InputError(
        fmt::format("--least-share is {} %; it must lie in [0, 100] %", flags.least_share));
  }
}

std::string SummaryJson(const scenario::Scenario& scenario,
                        const application::MonteCarloResult& result, const RunFlags& flags) {
  Json failures = Json::array();
  for (const application::SeedOutcome& outcome : result.outcomes) {
    if (outcome.succeeded) continue;
    failures.push_back(
        {{"seed", outcome.seed}, {"step", outcome.failed_step}, {"failure", outcome.failure}});
  }
  Json findings = Json::array();
  for (const application::FindingSpread& spread : result.Spreads()) {
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
                     {"wanted_share_percent", flags.least_share},
                     {"failures", failures},
                     {"findings", findings},
                     {"libm", FormatHash(LibmFingerprint())}};
  return TextOf(summary);
}

application::MonteCarloResult RunAll(const scenario::Scenario& scenario, const RunFlags& flags,
                                     const Host& host, const run::Catalogue& catalogue,
                                     const InterruptGuard& interrupt) {
  const MonotonicClock clock;
  Progress progress("seeds", Progress::StyleOfStdout(flags.quiet), clock);
  int done = 0;
  int failed = 0;
  const auto told = [&](const application::SeedOutcome& outcome) {
    ++done;
    if (!outcome.succeeded) {
      ++failed;
      Say(stderr, fmt::format("panda-twin: note: seed {}: {}\n", outcome.seed, outcome.failure));
    }
    progress.Show(static_cast<double>(done) / *flags.seeds,
                  fmt::format("{} of {}, {} failed", done, *flags.seeds, failed));
  };
  return application::RunSeeds(scenario, catalogue, FilesOf(flags, host), clock,
                               {.first_seed = scenario.seed,
                                .seeds = *flags.seeds,
                                .threads = flags.threads,
                                .interrupted = interrupt.flag()},
                               told);
}

}  // namespace

ExitCode RunManySeeds(const scenario::Scenario& scenario, const RunFlags& flags, const Host& host,
                      const run::Catalogue& catalogue) {
  RequireFlags(scenario, flags);
  RequireProgram("gnuplot", host.path, "apt-get install gnuplot-nox");
  const InterruptGuard interrupt;
  ResultFolder out(flags.out.empty() ? std::filesystem::path("out") / (scenario.name + "_seeds")
                                     : flags.out);
  out.Prepare();
  out.Clear();
  const application::MonteCarloResult result = RunAll(scenario, flags, host, catalogue, interrupt);
  interrupt.ThrowIfInterrupted();
  WriteWholeFile(out.scenario(), scenario::ToYaml(scenario));
  WriteWholeFile(out.seeds(), application::SeedsCsv(result));
  WriteWholeFile(out.summary(), SummaryJson(scenario, result, flags));
  WriteWholeFile(
      out.report(),
      application::SeedsPage(
          scenario, result,
          {{"application", scenario.application->type},
           {"seeds", fmt::format("{} to {}", scenario.seed,
                                 scenario.seed + static_cast<std::uint64_t>(*flags.seeds) - 1)},
           {"site", flags.lab ? "lab " + *flags.lab : "the scenario's own"},
           {"panda-twin", TWIN_VERSION}}));
  const std::string text = fmt::format(
      "{} of {} seeds succeeded: {:.1f} % (between {:.1f} and {:.1f} % by 95 % "
      "confidence)",
      result.succeeded, result.outcomes.size(), 100 * result.share(), 100 * result.least_share,
      100 * result.most_share);
  if (!flags.quiet) {
    Say(stdout, fmt::format("{}: {}\n  files  {}\n", scenario.name, text, out.folder().string()));
  }
  if (100 * result.share() >= flags.least_share) return kOk;
  throw RobotFault(fmt::format("{}; wanted are at least {} %, see {}", text, flags.least_share,
                               out.report().string()));
}

}  // namespace twin::cli
