#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string_view>
#include <vector>

#include "twin/core/random.h"
#include "twin/experiment/experiment.h"
#include "twin/record/cycle_record.h"
#include "twin/reference/trajectory.h"
#include "twin/run/run.h"
#include "twin/scenario/link_section.h"
#include "twin/scenario/robot_data.h"
#include "twin/scenario/scenario.h"

namespace twin::experiment {

/// Random choices of the experiments: seeds and start phases. Apart from all streams of a run.
inline constexpr RandomStream kExperimentStream{2000};

/// @throws RobotFault when Config::interrupted is set.
void ThrowIfInterrupted(const Config& config);

/// Seed of the `run`-th run of an experiment, from the config's.
[[nodiscard]] std::uint64_t SeedOfRun(const Config& config, int run) noexcept;

/// Uniform in [0, 1), from the config's seed: `what`-th choice of the `run`-th run.
[[nodiscard]] double ChoiceOfRun(const Config& config, int run, std::uint32_t what = 0) noexcept;

/// The same of the first choice, within a cycle: the phase of a source.
[[nodiscard]] Duration PhaseOfRun(const Config& config, int run, std::uint32_t what = 0) noexcept;

/// `name`.yaml of the config's scenarios, without log and video. @throws InputError as Load.
[[nodiscard]] scenario::Scenario LoadScenario(const Config& config, std::string_view name);

/// The robot of a scenario, and the trajectory that it plans. @throws InputError as LoadRobotData.
[[nodiscard]] scenario::RobotData RobotOf(const Config& config, const scenario::Scenario& scenario);
[[nodiscard]] reference::Trajectory PlanOf(const Config& config,
                                           const scenario::Scenario& scenario);

/// Makes every delay a constant, without drift, the states half a period after the wake-ups; losses
/// stay.
void RemoveTimingFaults(scenario::Scenario& scenario);

/// Every state takes 100 us: none comes late.
void SetConstantStateDelay(scenario::Scenario& scenario);

/// A pace of a motion, as shares of the limits of acceleration and speed.
struct Pace {
  std::string_view name;
  double stretch = 0;  ///< of the brisk trajectory's time; 0: the canonical trajectory
};

/// Canonical: 0.1 of the acceleration limits; brisk: 0.6, and 0.8 of the speed limits; hard: 0.85
/// and 0.95.
inline constexpr std::array<Pace, 3> kPaces{{{"canonical", 0}, {"brisk", 1}, {"hard", 0.84}}};

/// The brisk trajectory's waypoints with stretched times. @throws InputError as scenario::Load.
[[nodiscard]] scenario::MotionSection BriskMotion(const Config& config, double stretch);

/// Makes the scenario follow its own, canonical trajectory, or the brisk one, as joint positions.
/// @throws InputError as scenario::Load.
void SetPace(const Config& config, const Pace& pace, scenario::Scenario& scenario);

/// Bursts of lost messages.
struct Bursts {
  int length = 0;         ///< messages in a row
  double per_second = 2;  ///< mean rate
};

/// Bursts at random instants, which depend on run and `per_second` alone.
/// @param seconds  duration of the motion.
[[nodiscard]] scenario::Loss LossOf(const Config& config, const Bursts& bursts, double seconds,
                                    int run);

/// Runs a scenario, in lockstep or as RunOverWire. @param sink  may be null. @returns how it ended.
/// @throws as run::Run; RobotFault when Config::interrupted is set.
run::RunResult RunScenario(const Config& config, const scenario::Scenario& scenario,
                           record::RecordSink* sink);

/// Runs a scenario's loop on the wall clock, over UDP on this machine, against a robot of its own,
/// served as `panda-twin serve` does. Plant, sensors and start are the scenario's; delays and costs
/// are this machine's. One host has one clock: the robot runs slower by the controller's drift.
/// @param scenario  backend fci. @param sink  cycles come from the robot's thread, ticks from the
/// communication's; may be null.
/// @returns counts by the robot. @throws as RunScenario.
[[nodiscard]] run::RunResult RunOverWire(const Config& config, const scenario::Scenario& scenario,
                                         record::RecordSink* sink);

/// Calls job(0) ... job(count - 1) on the host's processors, on the wall clock one by one. When
/// jobs throw, the first exception in their order is thrown, once all are done. Reports progress
/// in [from, to], from the calling thread only. @param job  called from several threads at a time.
void InParallel(const Config& config, int count, const std::function<void(int)>& job,
                double from = 0, double to = 1);

/// The same with the jobs' results, in order.
template <class Job>
[[nodiscard]] auto MapInParallel(const Config& config, std::size_t count, const Job& job,
                                 double from = 0, double to = 1) {
  std::vector<decltype(job(0))> results(count);
  InParallel(
      config, static_cast<int>(count), [&](int i) { results[i] = job(i); }, from, to);
  return results;
}

/// Runs the calibrated asynchronous loop `runs` times. @param change  made to each run's scenario,
/// from several threads. @param from, to  as InParallel. @returns how many did not succeed.
[[nodiscard]] int CountFailures(const Config& config, int runs,
                                const std::function<void(scenario::Scenario&)>& change, double from,
                                double to);

}  // namespace twin::experiment
