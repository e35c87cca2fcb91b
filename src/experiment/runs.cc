#include "experiment/runs.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <exception>
#include <string>
#include <thread>

#include "experiment/wire_run.h"
#include "twin/core/error.h"
#include "twin/run/remote.h"

namespace twin::experiment {
namespace {

int Threads(const Setting& setting, int count) {
  if (setting.on_wall_clock) return 1;
  constexpr int kMost = 8;
  return std::clamp(static_cast<int>(std::thread::hardware_concurrency()), 1,
                    std::min(kMost, std::max(count, 1)));
}

}  // namespace

void ThrowIfInterrupted(const Setting& setting) {
  if (setting.interrupted == nullptr || !*setting.interrupted) return;
  throw RobotFault("the experiment was interrupted");
}

std::uint64_t SeedOfRun(const Setting& setting, int run) noexcept {
  const auto bits =
      Random(setting.seed, kExperimentStream).Bits(static_cast<std::uint64_t>(run), 0);
  return (std::uint64_t{bits[0]} << 32) | bits[1];
}

double ChoiceOfRun(const Setting& setting, int run, std::uint32_t what) noexcept {
  return Random(setting.seed, kExperimentStream).Uniform(static_cast<std::uint64_t>(run), what + 1);
}

Setting With(const Setting& setting, const run::Catalogue& catalogue) {
  return {.catalogue = catalogue,
          .files = setting.files,
          .scenarios = setting.scenarios,
          .scratch = setting.scratch,
          .seed = setting.seed,
          .seeds = setting.seeds,
          .is_calibrated = setting.is_calibrated,
          .on_wall_clock = setting.on_wall_clock,
          .progress = setting.progress,
          .interrupted = setting.interrupted};
}

scenario::Scenario LoadScenario(const Setting& setting, std::string_view name) {
  scenario::Scenario scenario = scenario::Load(setting.scenarios / (std::string(name) + ".yaml"));
  scenario.drive = scenario::Drive::kLockstep;
  scenario.backend = setting.on_wall_clock ? scenario::kRemoteBackend : "mujoco";
  scenario.render.enabled = false;
  scenario.record = false;
  return scenario;
}

void TakeOutTimingFaults(scenario::Scenario& scenario) {
  const auto constant = [](int us) {
    return scenario::Delay{rt::ConstantDelay{std::chrono::microseconds(us)}};
  };
  scenario.link.state.delay = constant(100);
  scenario.link.command.delay = constant(70);
  scenario.controller.wake_delay = constant(18);
  scenario.controller.cost = constant(65);
  scenario.controller.clock_drift_ppm = 0;
  scenario.controller.phase = std::chrono::microseconds(500);
}

run::RunResult RunScenario(const Setting& setting, const scenario::Scenario& scenario,
                           rt::RecordSink* sink) {
  ThrowIfInterrupted(setting);
  run::RunResult result;
  if (scenario.is_remote()) {
    result = RunOverWire(setting, scenario, sink);
  } else {
    run::Run run(scenario, setting.catalogue, setting.files, sink);
    run::RunHooks hooks;
    hooks.interrupted = setting.interrupted;
    result = run.Execute(hooks);
  }
  ThrowIfInterrupted(setting);
  return result;
}

void InParallel(const Setting& setting, int count, const std::function<void(int)>& job, double from,
                double to) {
  std::vector<std::exception_ptr> failures(static_cast<std::size_t>(count));
  // Both only count; what the jobs wrote is handed over by joining the threads.
  std::atomic<int> next{0};
  std::atomic<int> done{0};
  const auto work = [&](bool tells) {
    for (int i = next.fetch_add(1, std::memory_order_relaxed); i < count;
         i = next.fetch_add(1, std::memory_order_relaxed)) {
      try {
        ThrowIfInterrupted(setting);
        job(i);
      } catch (...) {
        failures[static_cast<std::size_t>(i)] = std::current_exception();
      }
      const int finished = done.fetch_add(1, std::memory_order_relaxed) + 1;
      if (tells && setting.progress) setting.progress(from + (to - from) * finished / count);
    }
  };
  {
    std::vector<std::jthread> helpers;
    for (int i = 1; i < Threads(setting, count); ++i) helpers.emplace_back(work, false);
    work(true);
  }
  for (const std::exception_ptr& failure : failures) {
    if (failure) std::rethrow_exception(failure);
  }
  if (setting.progress) setting.progress(to);
}

int CountFailures(const Setting& setting, int runs,
                  const std::function<void(scenario::Scenario&)>& change, double from, double to) {
  std::atomic<int> failures{0};
  InParallel(
      setting, runs,
      [&](int run) {
        scenario::Scenario scenario = LoadScenario(setting, "asynchronous");
        scenario.seed = SeedOfRun(setting, run);
        change(scenario);
        if (!RunScenario(setting, scenario, nullptr).report.succeeded()) ++failures;
      },
      from, to);
  return failures;
}

}  // namespace twin::experiment
