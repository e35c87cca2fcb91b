#include "campaign/trial.h"

#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <string_view>
#include <utility>

#include <fmt/format.h>

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

/// Carries out a world's application.
ApplicationEnd ExecuteApplication(const scenario::Scenario& world, const run::Catalogue& catalogue,
                                  const run::RunFiles& files, record::RecordSink* sink,
                                  const application::Partners* partners = nullptr) {
  const MonotonicClock clock;  // which only tells how long planning takes
  application::ApplicationRun run(world, catalogue, files, sink, clock, {}, partners);
  const application::TaskResult& task = run.Execute({});
  return {task.task.failure, run.session_result().states_hash};
}

/// The states of a world without a watch, and with pushes in another order.
std::uint64_t StatesAgain(scenario::Scenario world, const run::Catalogue& catalogue,
                          const run::RunFiles& files) {
  if (world.application) return ExecuteApplication(world, catalogue, files, nullptr).states_hash;
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
  const auto compare = [hash](std::uint64_t again, std::string_view how) -> std::optional<Finding> {
    if (again == hash) return std::nullopt;
    return Finding{"repeats",
                   fmt::format("states {}, {} {}", FormatHash(hash), how, FormatHash(again))};
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
  const Chance other = RunOnce(world, catalogue, files).chance;
  if (has_losses && other.lost_hash == chance.lost_hash) {
    return Finding{"seed", "with another seed the same messages are lost"};
  }
  if (has_costs && other.costs_hash == chance.costs_hash) {
    return Finding{"seed", "with another seed each tick takes as long"};
  }
  return std::nullopt;
}

void SetPlant(scenario::Scenario& world, robot::PlantKind kind) {
  world.plant = {};
  world.plant.kind = kind;
}

}  // namespace

Outcome RunOnce(const scenario::Scenario& world, const run::Catalogue& catalogue,
                const run::RunFiles& files, bool may_touch, const application::Partners* partners) {
  Outcome outcome;
  Watch watch(world, may_touch);
  const backend::Registry watched = watch.Watched(catalogue.backends);
  try {
    world.Validate();
    const run::Catalogue own{watched, catalogue.controllers, catalogue.devices};
    if (world.application) {
      const ApplicationEnd end = ExecuteApplication(world, own, files, &watch, partners);
      outcome.finding = watch.finding();
      outcome.failure = end.failure;
      outcome.end = world.application->type + (end.failure.empty() ? ": success" : ": failure");
      outcome.states_hash = end.states_hash;
    } else {
      run::Run run(world, own, files, &watch);
      const run::RunResult result = run.Execute();
      outcome.finding = watch.End(result);
      outcome.end = NameOf(result.report.end);
      if (result.report.errors.any()) outcome.end += ": " + FormatErrors(result.report.errors);
      outcome.states_hash = result.states_hash;
    }
  } catch (const InputError& error) {
    outcome.refusal = error.what();
  } catch (const RobotFault& fault) {
    outcome.refusal = fault.what();
  } catch (const run::NoPlanError& error) {
    outcome.refusal = error.what();
  } catch (const std::exception& error) {
    outcome.finding = Finding{"errors", error.what()};
  }
  outcome.cycles = watch.cycles();
  outcome.q = watch.q();
  const MessageWatch& messages = watch.messages();
  outcome.chance = {messages.lost_by_chance(), messages.losses_hash(), messages.drawn_costs(),
                    messages.costs_hash()};
  return outcome;
}

Outcome RunWorld(const scenario::Scenario& world, const run::Catalogue& catalogue,
                 const run::RunFiles& files, bool repeats) {
  Outcome outcome = RunOnce(world, catalogue, files);
  if (outcome.finding || !outcome.refusal.empty() || !repeats) return outcome;
  outcome.finding = Repeat(world, outcome.states_hash, catalogue, files);
  if (!outcome.finding) outcome.finding = Reseed(world, outcome.chance, catalogue, files);
  return outcome;
}

std::span<const Simplification> Simplifications() {
  using scenario::Scenario;
  static constexpr Simplification kSimplifications[] = {
      [](Scenario& w) { w.perturbations.clear(); },
      [](Scenario& w) {
        if (!w.perturbations.empty()) w.perturbations.pop_back();
      },
      [](Scenario& w) { w.base.reset(); },
      [](Scenario& w) { w.objects.clear(); },
      [](Scenario& w) { w.limits = {}; },
      [](Scenario& w) {
        if (!w.limits.regions.empty()) w.limits.regions.pop_back();
      },
      [](Scenario& w) { w.panel.clear(); },
      [](Scenario& w) {
        if (!w.panel.empty()) w.panel.pop_back();
      },
      [](Scenario& w) { w.hand.clear(); },
      [](Scenario& w) { w.link = {}; },
      [](Scenario& w) { w.link.state = {}; },
      [](Scenario& w) { w.link.command = {}; },
      [](Scenario& w) { w.link.state.loss = {}; },
      [](Scenario& w) { w.link.command.loss = {}; },
      [](Scenario& w) { w.link.state.duplication = {}, w.link.command.duplication = {}; },
      [](Scenario& w) { w.link.state.reordering = {}, w.link.command.reordering = {}; },
      [](Scenario& w) { w.link.state.delay = {}; },
      [](Scenario& w) { w.link.command.delay = {}; },
      [](Scenario& w) { SetPlant(w, robot::PlantKind::kIdeal), w.robot.load = {}; },
      [](Scenario& w) { SetPlant(w, w.plant.kind); },
      [](Scenario& w) { w.plant.arm = {}; },
      [](Scenario& w) { w.robot.load = {}, w.onboard.load = {}; },
      [](Scenario& w) {
        if (w.motion.poses.size() > 1) w.motion.poses.pop_back();
      },
      [](Scenario& w) { w.robot.clock_drift_ppm = 0; },
      [](Scenario& w) {
        w.onboard = {}, w.onboard.collision_behavior = scenario::NoCollisionBehavior();
      },
      [](Scenario& w) { w.onboard.filters = {}; },
      [](Scenario& w) { w.onboard.NE_T_EE = {}; },
      [](Scenario& w) { w.onboard.collision_behavior = scenario::NoCollisionBehavior(); },
      [](Scenario& w) { w.controller.rate_hz = 1000, w.controller.phase = {}; },
      [](Scenario& w) { w.controller.clock_drift_ppm = 0; },
      [](Scenario& w) { w.controller.target_noise = 0; },
      [](Scenario& w) { w.controller.cost = {}, w.controller.wake_delay = {}; },
      [](Scenario& w) { w.tick.cost = {}; },
      [](Scenario& w) { w.tick.limiter = false; },
      [](Scenario& w) { w.tick.viability.reset(); },
      [](Scenario& w) { w.tick.period_tolerance = {}; },
      [](Scenario& w) { w.loop = loop::LoopKind::kAsynchronous; },
      [](Scenario& w) { w.motion.controller = ControllerMode::kJointImpedance; },
      [](Scenario& w) {
        if (w.motion.waypoints.size() > 2) w.motion.waypoints.pop_back();
      },
      [](Scenario& w) { w.motion.timing = {}; },
      [](Scenario& w) { w.robot.hand = plant::HandKind::kNone, w.hand.clear(); },
  };
  return kSimplifications;
}

scenario::Scenario Shrink(scenario::Scenario world, std::string_view invariant,
                          const run::Catalogue& catalogue, const run::RunFiles& files) {
  for (bool smaller = true; smaller;) {
    smaller = false;
    for (const Simplification change : Simplifications()) {
      scenario::Scenario less = world;
      change(less);
      if (less == world) continue;
      const Outcome outcome = RunWorld(less, catalogue, files, NeedsRepeats(invariant));
      if (!outcome.finding || outcome.finding->invariant != invariant) continue;
      world = std::move(less);
      smaller = true;
    }
  }
  return world;
}

}  // namespace twin::campaign
