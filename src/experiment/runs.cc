#include "experiment/runs.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <string>
#include <thread>

#include "twin/core/error.h"

namespace twin::experiment {
namespace {

bool IsInterrupted(const Setting& setting) {
  return setting.interrupted != nullptr && *setting.interrupted;
}

void ThrowIfInterrupted(const Setting& setting) {
  if (IsInterrupted(setting)) throw RobotFault("the experiment was interrupted");
}

int Threads(int count) {
  constexpr int kMost = 8;
  return std::clamp(static_cast<int>(std::thread::hardware_concurrency()), 1,
                    std::min(kMost, std::max(count, 1)));
}

}  // namespace

std::uint64_t SeedOfRun(const Setting& setting, int run) noexcept {
  const auto bits =
      Random(setting.seed, kExperimentStream).Bits(static_cast<std::uint64_t>(run), 0);
  return (std::uint64_t{bits[0]} << 32) | bits[1];
}

double ChoiceOfRun(const Setting& setting, int run, std::uint32_t what) noexcept {
  return Random(setting.seed, kExperimentStream).Uniform(static_cast<std::uint64_t>(run), what + 1);
}

scenario::Scenario LoadScenario(const Setting& setting, std::string_view name) {
  scenario::Scenario scenario = scenario::Load(setting.scenarios / (std::string(name) + ".yaml"));
  scenario.drive = scenario::Drive::kLockstep;
  scenario.render.enabled = false;
  scenario.record = false;
  return scenario;
}

scenario::RunResult RunScenario(const Setting& setting, const scenario::Scenario& scenario,
                                rt::RecordSink* sink) {
  ThrowIfInterrupted(setting);
  scenario::Run run(scenario, setting.catalogue, setting.files, sink);
  scenario::RunHooks hooks;
  hooks.interrupted = setting.interrupted;
  scenario::RunResult result = run.Execute(hooks);
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
    for (int i = 1; i < Threads(count); ++i) helpers.emplace_back(work, false);
    work(true);
  }
  for (const std::exception_ptr& failure : failures) {
    if (failure) std::rethrow_exception(failure);
  }
  if (setting.progress) setting.progress(to);
}

}  // namespace twin::experiment
