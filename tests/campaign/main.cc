// panda-twin-campaign: the whole stack in seeded random scenarios, invariants checked in every
// cycle (README.md beside this file).

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <variant>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "campaign/application_world.h"
#include "campaign/cell_world.h"
#include "campaign/client_world.h"
#include "campaign/hang_watch.h"
#include "campaign/resources.h"
#include "campaign/scenario_world.h"
#include "campaign/trial.h"
#include "campaign/world.h"
#include "controllers/registration.h"
#include "plugins/backends.h"
#include "twin/core/error.h"
#include "twin/core/hash.h"
#include "twin/core/integer.h"
#include "twin/core/time.h"
#include "twin/run/result_folder.h"
#include "twin/run/work_pool.h"
#include "twin/scenario/data_directory.h"
#include "twin/scenario/scenario.h"

namespace twin::campaign {
namespace {

constexpr int kExitFinding = 1;
constexpr int kExitUsage = 3;
/// Worlds whose outcomes are reported together. Threads wait for the last world of a batch.
constexpr std::uint64_t kPerBatch = 8192;
constexpr std::uint64_t kPerBatchToFirst = 64;  ///< with --first
constexpr std::size_t kMostShrunk = 5;
constexpr double kMostRefused = 0.1;  ///< of drawn worlds, once they are enough
constexpr std::uint64_t kEnoughWorlds = 1000;
constexpr std::uint64_t kAgain = 64;  ///< worlds, for what they leave in memory
/// Bytes that those worlds may leave: half of one smallest allocation, 32 bytes, per world.
constexpr std::int64_t kMostKept = 1024;
constexpr double kUnlikelyInAll = 8;  ///< standard deviations
constexpr double kLossBias = 0.01;

struct Options {
  std::uint64_t worlds = 1000;
  std::uint64_t seed = 1;
  std::uint64_t repeat_every = 8;
  int threads = 2;
  double patience = 300;  ///< s of the wall clock, for each world
  bool prints = false;
  bool first = false;  ///< ends with the first finding, as it is
  std::filesystem::path around;
  std::filesystem::path out = "out/campaign";
  std::filesystem::path models;                  ///< --data
  std::vector<std::filesystem::path> scenarios;  ///< in place of drawn worlds
};

/// Worlds that are alike in something.
struct Worlds {
  std::uint64_t count = 0;
  std::uint64_t first = 0;  ///< seed
  std::string text;         ///< of the first

  void Add(std::uint64_t seed, const std::string& of_it) {
    if (count++ != 0) return;
    first = seed;
    text = of_it;
  }
};

/// Of all worlds, whatever the number of threads.
struct Totals {
  std::uint64_t worlds = 0;
  std::uint64_t cycles = 0;
  std::uint64_t refused = 0;
  WordHash digest;
  std::uint64_t states_hash = 0;  ///< of the last world
  std::map<std::string, Worlds> ends;
  std::map<std::string, Worlds> refusals;
  std::vector<std::pair<std::uint64_t, Finding>> findings;
  LossTally losses;

  void Add(std::uint64_t seed, const Outcome& outcome) {
    ++worlds;
    cycles += outcome.cycles;
    digest.AddWord(outcome.states_hash);
    states_hash = outcome.states_hash;
    losses.Add(outcome.chance.losses);
    if (outcome.finding) findings.emplace_back(seed, *outcome.finding);
    if (outcome.refusal.empty()) {
      ends[outcome.end].Add(seed, outcome.end);
    } else {
      ++refused;
      refusals[outcome.refusal.substr(0, outcome.refusal.find_first_of("0123456789"))].Add(
          seed, "refused: " + outcome.refusal);
    }
  }

  /// What a world alone is too short to show. The share is of what its ends bias: a motion ends
  /// with a state that came.
  [[nodiscard]] std::optional<Finding> JudgeLosses() const {
    const double off = std::abs(losses.lost - losses.expected);
    if (off <= kUnlikelyInAll * std::sqrt(losses.variance) + kLossBias * losses.expected) return {};
    return Finding{"link", fmt::format("laws of chance lost {} messages, and should have {:.1f}",
                                       losses.lost, losses.expected)};
  }

  /// Throws if too few worlds could run for what was tried to say something.
  void RequireRuns(bool drawn) const {
    if (refused == worlds) {
      throw InputError(
          "no world could run, for the reasons on standard output; so nothing was tried");
    }
    if (!drawn || worlds < kEnoughWorlds) return;
    if (static_cast<double>(refused) > kMostRefused * static_cast<double>(worlds)) {
      throw InputError(
          fmt::format("{} of {} worlds could not run, for the reasons on standard "
                      "output; more than {:g} % are too many",
                      refused, worlds, 100 * kMostRefused));
    }
  }
};

class Campaign {
 public:
  explicit Campaign(const Options& options)
      : options_(options), files_{options.models, {}, {}, false} {
    plugins::RegisterMujoco(backends_);
    controllers::RegisterControllers(controllers_);
    if (!options.around.empty()) around_ = scenario::Load(options.around);
  }

  int Run() {
    if (options_.prints) {
      fmt::print("{}", Describe(options_.seed));
      return 0;
    }
    if (!options_.scenarios.empty()) return RunFiles();
    run::MakeFolder(options_.out);  // what is found hours later needs it
    run::WorkPool pool(options_.threads);
    const std::uint64_t per_batch = options_.first ? kPerBatchToFirst : kPerBatch;
    bool goes_on = true;
    for (std::uint64_t done = 0; goes_on && done < options_.worlds; done += per_batch) {
      std::vector<Outcome> outcomes(std::min(per_batch, options_.worlds - done));
      pool.ForEach(outcomes.size(), [&](std::size_t i) {
        const std::uint64_t seed = options_.seed + done + i;
        const HangWatch::World running(hang_watch_, NameOf(seed), [&] { return Keep(seed); });
        outcomes[i] = Try(seed);
        // At once, since the campaign may be stopped; but which is the first, the batch tells.
        if (outcomes[i].finding && !options_.first) Tell(NameOf(seed), *outcomes[i].finding);
      });
      for (std::size_t i = 0; goes_on && i < outcomes.size(); ++i) {
        totals_.Add(options_.seed + done + i, outcomes[i]);
        if (!outcomes[i].finding || !options_.first) continue;
        Tell(NameOf(options_.seed + done + i), *outcomes[i].finding);
        goes_on = false;
      }
    }
    Report();
    const std::optional<Finding> of_losses = totals_.JudgeLosses();
    if (of_losses) Tell("all worlds together", *of_losses);
    const std::optional<Finding> of_resources = JudgeResources();
    if (of_resources) Tell("some worlds again", *of_resources);
    if (of_losses || of_resources || !totals_.findings.empty()) return kExitFinding;
    totals_.RequireRuns(!around_);
    return 0;
  }

 private:
  /// What is in use once the first worlds have run again, in a thread whose end gives back what it
  /// keeps for itself.
  [[nodiscard]] Resources UsedAfterWorldsAgain() {
    std::jthread([this] {
      for (std::uint64_t seed = options_.seed; seed - options_.seed < kAgain; ++seed) {
        const HangWatch::World running(hang_watch_, NameOf(seed));
        static_cast<void>(Try(seed));
      }
    }).join();
    return ResourcesInUse();
  }

  /// After many worlds all that is kept for the next ones is there.
  [[nodiscard]] std::optional<Finding> JudgeResources() {
    if (totals_.worlds < kEnoughWorlds) return {};
    const Resources before = UsedAfterWorldsAgain();
    const Resources after = UsedAfterWorldsAgain();
    if (after.heap <= before.heap + kMostKept && after.files <= before.files) return {};
    return Finding{"memory",
                   fmt::format("{} worlds that ran before leave {} bytes and {} files", kAgain,
                               after.heap - before.heap, after.files - before.files)};
  }

  /// Users who try their own controller want worlds of that alone.
  [[nodiscard]] bool IsOfClients(std::uint64_t seed) const {
    return !around_ && IsClientWorld(seed);
  }

  static std::string NameOf(std::uint64_t seed) { return fmt::format("world {}", seed); }

  [[nodiscard]] std::string Describe(std::uint64_t seed) const {
    return IsOfClients(seed) ? DescribeClientWorld(seed) : TextOf(Draw(seed));
  }

  [[nodiscard]] bool Repeats(std::uint64_t seed) const {
    return options_.repeat_every != 0 && seed % options_.repeat_every == 0;
  }

  [[nodiscard]] Outcome Try(std::uint64_t seed) const {
    try {
      return IsOfClients(seed) ? RunClientWorld(seed, catalogue_, files_)
                               : RunDrawn(Draw(seed), Repeats(seed));
    } catch (const std::exception& error) {
      Outcome failed;
      failed.finding = Finding{"errors", error.what()};
      return failed;
    }
  }

  [[nodiscard]] Outcome RunDrawn(const ScenarioWorld& world, bool repeats) const {
    const auto* cell = std::get_if<scenario::Cell>(&world);
    return cell != nullptr
               ? RunCell(*cell, catalogue_, files_, repeats)
               : RunWorld(std::get<scenario::Scenario>(world), catalogue_, files_, repeats);
  }

  int RunFiles() {
    const auto run = [this](const ScenarioWorld& world, const std::string& name) {
      const HangWatch::World running(hang_watch_, name);
      return RunDrawn(world, true);
    };
    const FileCounts counts = CheckFiles(options_.scenarios, run);
    if (counts.violating > 0) return kExitFinding;
    if (counts.refused == 0) return 0;
    throw InputError(
        fmt::format("{} of {} scenarios could not run, for the reasons on standard output",
                    counts.refused, options_.scenarios.size()));
  }

  [[nodiscard]] ScenarioWorld Draw(std::uint64_t seed) const {
    if (around_ && around_->application) return DrawAround(seed, *around_);
    if (around_) return DrawWorld(seed, &*around_);
    if (IsCellWorld(seed)) return DrawCellWorld(seed, options_.models);
    if (IsApplicationWorld(seed)) return DrawApplicationWorld(seed, options_.models);
    return DrawWorld(seed);
  }

  void Report() {
    fmt::print(
        "{} worlds from seed {}: {:.3f} h of the robot's time, {} refused, {} violated an invariant; "
        "digest {}\n",
        totals_.worlds, options_.seed, static_cast<double>(totals_.cycles) / 3.6e6, totals_.refused,
        totals_.findings.size(), FormatHash(totals_.digest.value()));
    if (totals_.worlds == 1) {  // as `panda-twin run` prints it
      fmt::print("  states hash {}\n", FormatHash(totals_.states_hash));
    }
    for (const auto& [end, worlds] : totals_.ends) Print(worlds);
    for (const auto& [why, worlds] : totals_.refusals) Print(worlds);
    if (!options_.first) ShrinkFindings();
  }

  static void Print(const Worlds& worlds) {
    fmt::print("  {:7}, first world {}: {}\n", worlds.count, worlds.first, worlds.text);
  }

  /// Ends the program, since a thread that hangs cannot be ended alone.
  [[noreturn]] void GiveUp(const HangWatch::World& world) const {
    std::string file;
    try {
      file = world.Keep();
    } catch (const Error& error) {
      file = error.what();
    }
    Tell(world.name(), {"ends", fmt::format("it still ran after --patience {:g} s{}{}",
                                            options_.patience, file.empty() ? "" : "; ", file)});
    std::_Exit(kExitFinding);
  }

  /// Writes a world as it was drawn. @returns the file's path.
  std::string Keep(std::uint64_t seed) const {
    const std::filesystem::path file =
        options_.out / fmt::format("world_{}.{}", seed, IsOfClients(seed) ? "txt" : "yaml");
    run::WriteWholeFile(file, Describe(seed));
    return file.string();
  }

  /// The first of each invariant.
  void ShrinkFindings() {
    std::vector<std::string_view> done;
    for (const auto& [seed, finding] : totals_.findings) {
      if (done.size() == kMostShrunk) return;
      if (std::ranges::find(done, finding.invariant) != done.end()) continue;
      done.push_back(finding.invariant);
      ShrinkFinding(seed, finding);
    }
  }

  void ShrinkFinding(std::uint64_t seed, const Finding& finding) {
    if (IsOfClients(seed)) {
      fmt::print("world {} shrunk: {}", seed, ShrinkClientWorld(seed, finding.invariant));
      return;
    }
    ScenarioWorld world = Draw(seed);
    CommonOf(world).description = fmt::format(
        "Shrunk from world {} of the reliability campaign{}, which violates the invariant {}.",
        seed, around_ ? " around " + options_.around.string() : "", finding.invariant);
    const std::string file = Keep(seed);  // shrinking may take long
    const Shrunk shrunk = ShrinkScenario(world, finding.invariant,
                                         [&](const ScenarioWorld& less, const std::string& name) {
                                           const HangWatch::World running(hang_watch_, name);
                                           return RunDrawn(less, Repeats(seed));
                                         });
    run::WriteWholeFile(file, shrunk.text);
    fmt::print("world {} shrunk, {}: {}\n", seed, file,
               shrunk.finding ? shrunk.finding->text : "run once more, it violates nothing");
    std::fflush(stdout);
  }

  const Options options_;
  const run::RunFiles files_;
  backend::Registry backends_;
  control::ControllerRegistry controllers_;
  const run::Catalogue catalogue_{backends_, controllers_};
  std::optional<scenario::Scenario> around_;
  Totals totals_;
  HangWatch hang_watch_{FromSeconds(options_.patience),
                        [this](const HangWatch::World& world) { GiveUp(world); }};
};

/// CLI11 would take -1 as a large number, clamp what is too large, and read 010 as octal.
const CLI::Validator kWhole(
    [](const std::string& text) {
      const bool is_octal = text.size() > 1 && text.front() == '0';
      return ParseInteger<std::uint64_t>(text) && !is_octal
                 ? std::string()
                 : fmt::format(
                       "\"{}\" is not a whole number from 0 to 2^64 - 1, without a leading 0",
                       text);
    },
    "");

/// @param given  by the user; empty: beside the installed program, else of the source tree.
std::filesystem::path ModelsOf(const std::filesystem::path& given) {
  try {
    return scenario::FindDataDirectory({std::filesystem::read_symlink("/proc/self/exe"), given, {}})
        .models;
  } catch (const EnvironmentError&) {
    return std::filesystem::path(TWIN_SOURCE_DIR) / "models";
  }
}

/// Beside scenario files.
void RequireNoneOfDrawnWorlds(const CLI::App& app) {
  for (const CLI::Option* option : app.get_options()) {
    const std::string& name = option->get_name();
    const bool is_of_files = name == "SCENARIO" || name == "--data" || name == "--patience";
    if (is_of_files || option->empty()) continue;
    throw InputError(
        fmt::format("{} is for drawn worlds; leave it out, or the scenario files", name));
  }
}

int Main(int argc, char** argv) {
  Options options;
  CLI::App app(
      "Runs the whole stack in seeded random scenarios (worlds), or in those of files, in lockstep, and checks invariants "
      "in every cycle. Exit codes: 0 none is violated; 1 at least one is; 3 a wrong input.",
      "panda-twin-campaign");
  app.add_option("--worlds", options.worlds, "Draw so many worlds")
      ->check(kWhole)
      ->capture_default_str();
  app.add_option("--seed", options.seed, "Number of the first world; the others follow")
      ->check(kWhole)
      ->capture_default_str();
  app.add_option(
      "--around", options.around,
      "A scenario with a motion: its robot, motion and controller stay, and links, clocks, plant and pushes are drawn; "
      "of an application, links, clocks and pushes");
  app.add_option(
         "--repeat-every", options.repeat_every,
         "Of so many worlds one is run again: from its text, with a log, with another seed; 0: none")
      ->check(kWhole)
      ->capture_default_str();
  app.add_option("--threads", options.threads, "Run so many worlds at once")
      ->check(CLI::Range(1, 256))
      ->capture_default_str();
  app.add_option("--patience", options.patience,
                 "End the campaign with a world that takes longer on the wall clock, s; 0: wait")
      ->check(CLI::Range(0.0, 1e9))
      ->capture_default_str();
  app.add_option("--out", options.out, "Folder for the scenarios of what is found, shrunk")
      ->capture_default_str();
  app.add_option("--data", options.models, "Folder of models, if not beside the program");
  app.add_flag("--first", options.first,
               "End with the first world that violates an invariant, and do not shrink it");
  app.add_flag("--print", options.prints, "Only print the scenario of world --seed");
  app.add_option("SCENARIO", options.scenarios,
                 "Files to check in place of drawn worlds; beside them only --data and --patience");
  try {
    app.parse(argc, argv);
    if (!options.scenarios.empty()) RequireNoneOfDrawnWorlds(app);
    options.models = ModelsOf(options.models);
    if (options.worlds == 0)
      throw InputError("--worlds 0: nothing would be tried; give one or more");
    if (options.worlds - 1 > ~options.seed) {
      throw InputError(
          fmt::format("--worlds {} from --seed {} go beyond 2^64 - 1; give a smaller seed",
                      options.worlds, options.seed));
    }
    if (std::isnan(options.patience))
      throw InputError("--patience nan: give seconds, or 0 to wait");
    TellCrashes();
    const int code = Campaign(options).Run();
    if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0) {
      throw EnvironmentError("standard output cannot be written, so what it shows is not complete");
    }
    return code;
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : kExitUsage;
  } catch (const Error& error) {
    fmt::print(stderr, "panda-twin-campaign: {}\n", error.what());
  } catch (const std::filesystem::filesystem_error& error) {  // no folder for temporary files
    fmt::print(stderr, "panda-twin-campaign: {}; does TMPDIR name a folder?\n", error.what());
  }
  return kExitUsage;
}

}  // namespace
}  // namespace twin::campaign

int main(int argc, char** argv) {
  return twin::campaign::Main(argc, argv);
}
