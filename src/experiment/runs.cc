#include "experiment/runs.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <exception>
#include <string>
#include <thread>

#include "twin/core/error.h"

namespace twin::experiment {
namespace {

int Threads(const Config& config, int count) {
  if (config.on_wall_clock) return 1;
  constexpr int kMost = 8;
  return std::clamp(static_cast<int>(std::thread::hardware_concurrency()), 1,
                    std::min(kMost, std::max(count, 1)));
}

scenario::Delay ConstantDelay(int us) {
  return {faults::ConstantDelay{std::chrono::microseconds(us)}};
}

}  // namespace

void ThrowIfInterrupted(const Config& config) {
  if (config.interrupted == nullptr || !*config.interrupted) return;
  throw RobotFault("the experiment was interrupted");
}

std::uint64_t SeedOfRun(const Config& config, int run) noexcept {
  const auto bits = Random(config.seed, kExperimentStream).Bits(static_cast<std::uint64_t>(run), 0);
  return (std::uint64_t{bits[0]} << 32) | bits[1];
}

double ChoiceOfRun(const Config& config, int run, std::uint32_t what) noexcept {
  return Random(config.seed, kExperimentStream).Uniform(static_cast<std::uint64_t>(run), what + 1);
}

Duration PhaseOfRun(const Config& config, int run, std::uint32_t what) noexcept {
  return FromSeconds(kCycleSeconds * ChoiceOfRun(config, run, what));
}

scenario::Scenario LoadScenario(const Config& config, std::string_view name) {
  scenario::Scenario scenario = scenario::Load(config.scenarios / (std::string(name) + ".yaml"));
  scenario.drive = scenario::Drive::kLockstep;
  scenario.backend = config.on_wall_clock ? scenario::kRemoteBackend : "mujoco";
  scenario.render.enabled = false;
  scenario.record = false;
  return scenario;
}

scenario::RobotData RobotOf(const Config& config, const scenario::Scenario& scenario) {
  return scenario::LoadRobotData(config.files.models, scenario.robot.model, scenario.robot.hand);
}

reference::Trajectory PlanOf(const Config& config, const scenario::Scenario& scenario) {
  return run::MakeTrajectory(scenario, RobotOf(config, scenario));
}

void RemoveTimingFaults(scenario::Scenario& scenario) {
  scenario.link.state.delay = ConstantDelay(100);
  scenario.link.command.delay = ConstantDelay(70);
  scenario.controller.wake_delay = ConstantDelay(18);
  scenario.controller.cost = ConstantDelay(65);
  scenario.controller.clock_drift_ppm = 0;
  scenario.controller.phase = std::chrono::microseconds(500);
}

void SetConstantStateDelay(scenario::Scenario& scenario) {
  scenario.link.state.delay = ConstantDelay(100);
}

scenario::MotionSection BriskMotion(const Config& config, double stretch) {
  scenario::MotionSection motion =
      scenario::Load(config.files.models / "scenarios" / "brisk.yaml").motion;
  for (reference::Waypoint& waypoint : motion.waypoints) {
    if (waypoint.at) waypoint.at = FromSeconds(ToSeconds(*waypoint.at) * stretch);
  }
  return motion;
}

void SetPace(const Config& config, const Pace& pace, scenario::Scenario& scenario) {
  if (pace.stretch == 0) return;
  scenario.motion = BriskMotion(config, pace.stretch);
  scenario.motion.interface = control::CommandInterface::kJointPosition;
  scenario.motion.timing.duration.reset();
}

scenario::Loss LossOf(const Config& config, const Bursts& bursts, double seconds, int run) {
  scenario::ScriptedLoss script;
  std::uint32_t draw = 0;
  std::int64_t at = 20;  // ms: the motion has begun
  for (;;) {
    const double wait = -std::log1p(-ChoiceOfRun(config, run, ++draw)) / bursts.per_second;
    at += std::llround(1e3 * wait) + 1;
    if (static_cast<double>(at + bursts.length) > 1e3 * seconds) break;
    script.bursts.push_back(
        {std::chrono::milliseconds(at), static_cast<std::uint64_t>(bursts.length)});
    at += bursts.length;
  }
  return {script};
}

run::RunResult RunScenario(const Config& config, const scenario::Scenario& scenario,
                           record::RecordSink* sink) {
  ThrowIfInterrupted(config);
  run::RunResult result;
  if (scenario.is_remote()) {
    result = RunOverWire(config, scenario, sink);
  } else {
    run::Run run(scenario, config.catalogue, config.files, sink);
    run::RunHooks hooks;
    hooks.interrupted = config.interrupted;
    result = run.Execute(hooks);
  }
  ThrowIfInterrupted(config);
  return result;
}

void InParallel(const Config& config, int count, const std::function<void(int)>& job, double from,
                double to) {
  std::vector<std::exception_ptr> failures(static_cast<std::size_t>(count));
  // Both only count; what the jobs wrote is handed over by joining the threads.
  std::atomic<int> next{0};
  std::atomic<int> done{0};
  const auto work = [&](bool tells) {
    for (int i = next.fetch_add(1, std::memory_order_relaxed); i < count;
         i = next.fetch_add(1, std::memory_order_relaxed)) {
      try {
        ThrowIfInterrupted(config);
        job(i);
      } catch (...) {
        failures[static_cast<std::size_t>(i)] = std::current_exception();
      }
      const int finished = done.fetch_add(1, std::memory_order_relaxed) + 1;
      if (tells && config.progress) config.progress(from + (to - from) * finished / count);
    }
  };
  {
    std::vector<std::jthread> helpers;
    for (int i = 1; i < Threads(config, count); ++i) helpers.emplace_back(work, false);
    work(true);
  }
  for (const std::exception_ptr& failure : failures) {
    if (failure) std::rethrow_exception(failure);
  }
  if (config.progress) config.progress(to);
}

int CountFailures(const Config& config, int runs,
                  const std::function<void(scenario::Scenario&)>& change, double from, double to) {
  const auto failed = [&](int run) {
    scenario::Scenario scenario = LoadScenario(config, "asynchronous");
    scenario.seed = SeedOfRun(config, run);
    change(scenario);
    return RunScenario(config, scenario, nullptr).report.succeeded() ? 0 : 1;
  };
  return static_cast<int>(std::ranges::count(MapInParallel(config, runs, failed, from, to), 1));
}

}  // namespace twin::experiment
