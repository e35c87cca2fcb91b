#include "experiment/runs.h"

#include <atomic>
#include <chrono>
#include <cmath>
#include <exception>
#include <thread>

#include "twin/core/error.h"
#include "twin/robot/robot_config.h"
#include "twin/run/remote.h"
#include "twin/server/served_robot.h"

namespace twin::experiment {
namespace {

int Threads(const Config& config, int count) {
  if (config.on_wall_clock) return 1;
  constexpr int kMost = 8;
  return std::clamp(static_cast<int>(std::thread::hardware_concurrency()), 1,
                    std::min(kMost, std::max(count, 1)));
}

Duration PlannedAt(std::size_t cycle, double delay_s) {
  return FromSeconds(static_cast<double>(cycle) * kCycleSeconds - delay_s);
}

/// Runs a scenario's loop over UDP against a robot served here. Plant, sensors and start are the
/// scenario's. One host has one clock: the robot runs slower by the controller's drift.
run::RunResult RunOverWire(const Config& config, const scenario::Scenario& scenario,
                           record::RecordSink* sink) {
  scenario::Scenario served = scenario;
  served.robot.clock_drift_ppm -= scenario.controller.clock_drift_ppm;
  run::CycleCounts counts;
  SinkTo robot_sink([&](const record::CycleRecord& record) {
    counts.Add(record);
    if (sink != nullptr) sink->Put(record);
  });
  const robot::RobotConfig robot_config = run::MakeServedConfig(served, config.files);
  server::ServedRobot robot(robot_config, robot::MakePlant(robot_config),
                            {.takes_free_ports = true, .sink = &robot_sink});
  robot.Start();

  scenario::Scenario remote = scenario;
  remote.controller.clock_drift_ppm = 0;
  // The cycles are the robot's own, not the workstation's view of them.
  SinkTo ticks([sink](const record::TickRecord& record) {
    if (sink != nullptr) sink->Put(record);
  });
  run::RealtimeConfig settings;
  settings.remote = {.host = "127.0.0.1", .arm_port = robot.arm().port};
  settings.checks_start = false;
  run::RunResult result =
      run::Run(remote, config.catalogue, config.files, &ticks, settings)
          .Execute({.progress = {}, .event = {}, .interrupted = config.interrupted});
  robot.End();
  result.counts = counts;
  result.report.robot_timings.lateness = robot.lateness();
  result.report.robot_timings.overruns = robot.overruns();
  return result;
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

scenario::Scenario LoadScenario(const Config& config, std::string_view name, int run) {
  scenario::Scenario scenario = scenario::Load(config.scenarios / (std::string(name) + ".yaml"));
  scenario.drive = scenario::Drive::kLockstep;
  scenario.backend = config.on_wall_clock ? scenario::kRemoteBackend : "mujoco";
  scenario.render.enabled = false;
  scenario.record = false;
  scenario.seed = SeedOfRun(config, run);
  return scenario;
}

scenario::RobotData RobotOf(const Config& config, const scenario::Scenario& scenario) {
  return scenario::LoadRobotData(config.files.models, scenario.robot.model, scenario.robot.hand);
}

reference::Trajectory PlanOf(const Config& config, const scenario::Scenario& scenario) {
  return run::MakeTrajectory(scenario, RobotOf(config, scenario));
}

scenario::Delay ConstantDelay(int us) {
  return {faults::ConstantDelay{std::chrono::microseconds(us)}};
}

void RemoveTimingFaults(scenario::Scenario& scenario) {
  scenario.link.state.delay = ConstantDelay(100);
  scenario.link.command.delay = ConstantDelay(70);
  scenario.controller.wake_delay = ConstantDelay(18);
  scenario.controller.cost = ConstantDelay(65);
  scenario.controller.clock_drift_ppm = 0;
  scenario.controller.phase = std::chrono::microseconds(500);
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

scenario::Loss LossOf(const Config& config, const Bursts& bursts, Duration motion, int run) {
  scenario::ScriptedLoss script;
  std::uint32_t draw = 0;
  std::int64_t at = 20;  // ms: the motion has begun
  for (;;) {
    const double wait = -std::log1p(-ChoiceOfRun(config, run, ++draw)) / bursts.per_second;
    at += std::llround(1e3 * wait) + 1;
    if (static_cast<double>(at + bursts.length) > 1e3 * ToSeconds(motion)) break;
    script.bursts.push_back(
        {std::chrono::milliseconds(at), static_cast<std::uint64_t>(bursts.length)});
    at += bursts.length;
  }
  return {script};
}

run::RunResult RunScenario(const Config& config, const scenario::Scenario& scenario,
                           record::RecordSink* sink) {
  ThrowIfInterrupted(config);
  run::RunResult result =
      scenario.is_remote()
          ? RunOverWire(config, scenario, sink)
          : run::Run(scenario, config.catalogue, config.files, sink)
                .Execute({.progress = {}, .event = {}, .interrupted = config.interrupted});
  ThrowIfInterrupted(config);
  return result;
}

Config PartOf(const Config& config, double from, double to) {
  Config part = config;
  if (!config.progress) return part;
  part.progress = [from, to, whole = config.progress](double share) {
    whole(std::lerp(from, to, share));
  };
  return part;
}

void InParallel(const Config& config, int count, const std::function<void(int)>& job) {
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
      const double finished = done.fetch_add(1, std::memory_order_relaxed) + 1;
      if (tells && config.progress) config.progress(finished / count);
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
  if (config.progress) config.progress(1);
}

double FailedShare(const Config& config, int runs,
                   const std::function<void(scenario::Scenario&)>& change) {
  const auto failed = [&](int run) {
    scenario::Scenario scenario = LoadScenario(config, "asynchronous", run);
    change(scenario);
    return RunScenario(config, scenario).report.succeeded() ? 0 : 1;
  };
  return static_cast<double>(std::ranges::count(MapInParallel(config, runs, failed), 1)) / runs;
}

Recording::Recording() {
  cycles_.reserve(kMostRecords);
  ticks_.reserve(kMostRecords);
}

void Recording::Put(const record::CycleRecord& record) noexcept {
  if (record.fate == record::CommandFate::kNone) return;
  cycles_.push_back({.message_id = record.state.message_id,
                     .q = record.state.q,
                     .dq = record.state.dq,
                     .q_d = record.state.q_d,
                     .dq_d = record.state.dq_d,
                     .tau_J_d = record.state.tau_J_d});
}

void Recording::Put(const record::TickRecord& record) noexcept {
  if (record.action != record::TickAction::kWritten) return;
  ticks_.push_back({.message_id = record.message_id,
                    .deposit_time = record.deposit_time,
                    .dq_ext = record.dq_ext,
                    .dq_c = record.command.dq_c,
                    .margin = record.margin,
                    .kept_back = record.kept_back});
}

std::vector<double> Signal(const std::vector<CycleSample>& cycles, JointVector CycleSample::*field,
                           std::size_t joint, std::size_t begin, std::size_t end) {
  std::vector<double> signal;
  for (std::size_t k = begin; k < std::min(end, cycles.size()); ++k) {
    signal.push_back((cycles[k].*field)[joint]);
  }
  return signal;
}

std::size_t PlannedCycles(const reference::Trajectory& plan,
                          const std::vector<CycleSample>& cycles) {
  return std::min(cycles.size(), static_cast<std::size_t>(plan.duration() / kCycle));
}

double DelayBehind(const reference::Trajectory& plan, const std::vector<CycleSample>& cycles,
                   JointVector CycleSample::*field) {
  const std::size_t end = PlannedCycles(plan, cycles);
  return LeastSquaresDelay(4, [&](double delay_s) {
    DelaySums sums;
    for (std::size_t k = 0; k < end; ++k) {
      const reference::JointTarget target = plan.Sample(PlannedAt(k, delay_s));
      for (std::size_t j = 0; j < kJoints; ++j) {
        sums.product += (target.q[j] - (cycles[k].*field)[j]) * target.dq[j];
        sums.square += target.dq[j] * target.dq[j];
      }
    }
    return sums;
  });
}

JointVector RmsError(const reference::Trajectory& plan, const std::vector<CycleSample>& cycles,
                     JointVector CycleSample::*field, double delay_s) {
  const std::size_t end = PlannedCycles(plan, cycles);
  JointVector rms{};
  for (std::size_t k = 0; k < end; ++k) {
    const reference::JointTarget target = plan.Sample(PlannedAt(k, delay_s));
    for (std::size_t j = 0; j < kJoints; ++j) {
      rms[j] += std::pow((cycles[k].*field)[j] - target.q[j], 2);
    }
  }
  for (double& x : rms) x = end == 0 ? 0 : std::sqrt(x / static_cast<double>(end));
  return rms;
}

std::array<std::vector<double>, kJoints> PlannedVelocities(const reference::Trajectory& plan) {
  std::array<std::vector<double>, kJoints> velocities;
  for (Duration t{}; t < plan.duration(); t += kCycle) {
    const JointVector dq = plan.Sample(t).dq;
    for (std::size_t j = 0; j < kJoints; ++j) velocities[j].push_back(dq[j]);
  }
  return velocities;
}

}  // namespace twin::experiment
