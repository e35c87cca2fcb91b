#include "campaign/trial.h"

#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "campaign/first_difference.h"
#include "campaign/page_people.h"
#include "campaign/record_hash.h"
#include "twin/application/application.h"
#include "twin/core/clock.h"
#include "twin/core/error.h"
#include "twin/core/hash.h"
#include "twin/page/live_feed.h"
#include "twin/run/result_folder.h"
#include "twin/run/run.h"
#include "twin/run/run_records.h"

namespace twin::campaign {
namespace {

struct ApplicationEnd {
  std::string failure;  ///< empty: the task succeeded
  std::uint64_t states_hash = 0;
};

/// Carries out a world's application. @param talk  at the operator's page.
ApplicationEnd ExecuteApplication(const scenario::Scenario& world, const run::Catalogue& catalogue,
                                  const run::RunFiles& files, record::RecordSink* sink,
                                  PageTalk& talk, const application::Partners* partners = nullptr) {
  const MonotonicClock clock;  // which only tells how long planning takes
  const teleop::DeviceRegistry devices = DevicesOfPeople(talk);
  const run::Catalogue own{catalogue.backends, catalogue.controllers, &devices};
  StandWatch stands(talk, sink);
  application::ApplicationRun run(world, own, files, &stands, clock, {}, partners);
  const application::TaskResult& task = run.Execute({});
  return {task.task.failure, run.session_result().states_hash};
}

/// The states of a world without a watch, and with pushes in another order.
std::uint64_t StatesAgain(scenario::Scenario world, const run::Catalogue& catalogue,
                          const run::RunFiles& files) {
  if (world.application) {
    PageTalk again;
    return ExecuteApplication(world, catalogue, files, nullptr, again).states_hash;
  }
  // A sum of two forces has no order; one of more rounds by it.
  if (world.perturbations.size() == 2) std::ranges::reverse(world.perturbations);
  return run::Run(world, catalogue, files, nullptr).Execute().states_hash;
}

/// The same under a page's feed, and with a log, which holds what was put.
std::uint64_t StatesWithLog(const scenario::Scenario& world, const run::Catalogue& catalogue,
                            const run::RunFiles& files) {
  const run::ScratchFolder scratch(
      std::filesystem::temp_directory_path() /
      fmt::format("panda-twin-campaign-{}-{}", ::getpid(), world.name));
  const std::filesystem::path log = scratch.path() / "log.mcap";
  run::RunRecords records;
  RecordHash put(&records);
  page::LiveFeed page(&put);
  run::Run run(world, catalogue, files, &page);
  records.Log(log, run::InfoOf(world, run.robot()), record::FullRing::kWait);
  const std::uint64_t hash = run.Execute().states_hash;
  static_cast<void>(records.Finish());
  if (run::StatesHashOf(log) != hash) throw Error("the log holds other states than the run had");
  if (RecordHashOf(log) != put.value()) throw Error("the log holds other records than were put");
  return hash;
}

std::optional<Finding> Repeat(const scenario::Scenario& world, std::uint64_t hash,
                              const run::Catalogue& catalogue, const run::RunFiles& files) {
  const auto compare = [&](std::uint64_t again, std::string_view how) -> std::optional<Finding> {
    if (again == hash) return std::nullopt;
    return Finding{
        "repeats",
        fmt::format("states {}, {} {}{}", FormatHash(hash), how, FormatHash(again),
                    world.application ? "" : "; " + FirstDifference(world, catalogue, files))};
  };
  try {
    const scenario::Scenario read = scenario::Parse(scenario::ToYaml(world), world.name + ".yaml");
    if (!(read == world)) throw Error("its text, read back, is another world");
    auto finding = compare(StatesAgain(read, catalogue, files), "from its text");
    if (finding || world.application) return finding;
    return compare(StatesWithLog(read, catalogue, files), "with a log and a page");
  } catch (const Error& error) {
    return Finding{"repeats", error.what()};
  }
}

/// With another seed, other messages are lost and computations take another time.
std::optional<Finding> Reseed(scenario::Scenario world, const Chance& chance,
                              const run::Catalogue& catalogue, const run::RunFiles& files) {
  constexpr std::uint64_t kEnough = 20;  // draws, to be never the same
  const bool has_losses = chance.lost >= kEnough;
  const bool has_costs = chance.costs >= kEnough;
  if (world.application || (!has_losses && !has_costs)) return std::nullopt;
  world.seed += 1ULL << 32;
  const Outcome again = RunOnce(world, catalogue, files);
  const Chance& other = again.chance;
  if (again.finding) return again.finding;
  if (has_losses && other.lost_hash == chance.lost_hash) {
    return Finding{"seed", "with another seed the same messages are lost"};
  }
  if (has_costs && other.costs_hash == chance.costs_hash) {
    return Finding{"seed", "with another seed each tick takes as long"};
  }
  return std::nullopt;
}

}  // namespace

Outcome RunOnce(const scenario::Scenario& world, const run::Catalogue& catalogue,
                const run::RunFiles& files, bool may_touch, const application::Partners* partners) {
  Outcome outcome;
  PageTalk talk;
  Watch watch(world, may_touch);
  const backend::Registry watched = watch.Watched(catalogue.backends);
  try {
    world.Validate();
    const run::Catalogue own{watched, catalogue.controllers, catalogue.devices};
    if (world.application) {
      const ApplicationEnd end = ExecuteApplication(world, own, files, &watch, talk, partners);
      outcome.failure = end.failure;
      outcome.end = world.application->type + (end.failure.empty() ? ": success" : ": failure");
      outcome.states_hash = end.states_hash;
    } else {
      run::Run run(world, own, files, &watch);
      const run::RunResult result = run.Execute();
      watch.End(result);
      outcome.end = NameOf(result.report.end);
      if (result.report.errors.any()) outcome.end += ": " + FormatErrors(result.report.errors);
      outcome.states_hash = result.states_hash;
    }
  } catch (const InputError& error) {
    outcome.refusal = error.what();
  } catch (const RobotFault& fault) {  // the panel before the motion
    if (world.panel.empty()) outcome.finding = Finding{"errors", fault.what()};
    outcome.refusal = fault.what();
  } catch (const run::NoPlanError& error) {
    outcome.refusal = error.what();
  } catch (const std::exception& error) {
    outcome.finding = Finding{"errors", error.what()};
  }
  if (talk.finding) outcome.finding = talk.finding;
  if (watch.finding()) outcome.finding = watch.finding();  // also of a run that was broken off
  outcome.cycles = watch.path().size();
  outcome.path = watch.path();
  const MessageWatch& messages = watch.messages();
  outcome.chance = {messages.lost_by_chance(), messages.losses_hash(), messages.changed_costs(),
                    messages.costs_hash(), messages.tally()};
  return outcome;
}

Outcome RunWorld(const scenario::Scenario& world, const run::Catalogue& catalogue,
                 const run::RunFiles& files, bool repeats) {
  Outcome outcome = RunOnce(world, catalogue, files);
  outcome.path = std::vector<JointVector>();  // {} would keep its memory
  if (outcome.finding || !outcome.refusal.empty() || !repeats) return outcome;
  outcome.finding = Repeat(world, outcome.states_hash, catalogue, files);
  if (!outcome.finding) outcome.finding = Reseed(world, outcome.chance, catalogue, files);
  return outcome;
}

}  // namespace twin::campaign
