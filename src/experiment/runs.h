#pragma once

#include <type_traits>
#include <utility>

#include "experiment/statistics.h"
#include "twin/core/joint_vector.h"
#include "twin/core/random.h"
#include "twin/record/cycle_record.h"
#include "twin/reference/trajectory.h"
#include "twin/scenario/robot_data.h"
#include "twin/scenario/scenario.h"

// Runs of scenarios: their seeds, their execution, and what they record.
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

/// `name`.yaml of the config's scenarios, without log and video, with the seed of a run.
/// @throws InputError as Load.
[[nodiscard]] scenario::Scenario LoadScenario(const Config& config, std::string_view name,
                                              int run = 0);

/// The robot of a scenario, and the trajectory that it plans. @throws InputError as LoadRobotData.
[[nodiscard]] scenario::RobotData RobotOf(const Config& config, const scenario::Scenario& scenario);
[[nodiscard]] reference::Trajectory PlanOf(const Config& config,
                                           const scenario::Scenario& scenario);

[[nodiscard]] scenario::Delay ConstantDelay(int us);

/// Makes every delay a constant, without drift, the states half a period after the wake-ups; losses
/// stay.
void RemoveTimingFaults(scenario::Scenario& scenario);

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

/// Bursts at random instants within a motion, which depend on run and `per_second` alone.
[[nodiscard]] scenario::Loss LossOf(const Config& config, const Bursts& bursts, Duration motion,
                                    int run);

/// Runs a scenario in lockstep; with backend fci on the wall clock, over UDP on this machine,
/// against a robot of its own, served as `panda-twin serve` does: delays and costs are then this
/// machine's. @param sink  may be null; on the wall clock cycles come from the robot's thread,
/// ticks from the communication's. @returns how it ended, with the robot's counts.
/// @throws as run::Run; RobotFault when Config::interrupted is set.
run::RunResult RunScenario(const Config& config, const scenario::Scenario& scenario,
                           record::RecordSink* sink = nullptr);

/// @returns the config of a part of the work, whose progress is that from `from` to `to`.
[[nodiscard]] Config PartOf(const Config& config, double from, double to);

/// Calls job(0) ... job(count - 1) on the host's processors, on the wall clock one by one. When
/// jobs throw, the first exception in their order is thrown, once all are done. Reports progress
/// from the calling thread only. @param job  called from several threads at a time.
void InParallel(const Config& config, int count, const std::function<void(int)>& job);

/// The same with the jobs' results, in order.
template <class Job>
[[nodiscard]] auto MapInParallel(const Config& config, std::size_t count, const Job& job) {
  std::vector<decltype(job(0))> results(count);
  InParallel(config, static_cast<int>(count), [&](int i) { results[i] = job(i); });
  return results;
}

/// Results in rows.
template <class Result>
struct Grid {
  std::size_t columns = 0;
  std::vector<Result> all;  ///< row by row

  [[nodiscard]] std::size_t rows() const { return all.size() / columns; }
  [[nodiscard]] std::span<const Result> operator[](std::size_t row) const {
    return std::span(all).subspan(row * columns, columns);
  }
};

/// As MapInParallel, with job(row, column).
template <class Job>
[[nodiscard]] auto MapGrid(const Config& config, std::size_t rows, std::size_t columns,
                           const Job& job) {
  const auto at = [&](std::size_t i) { return job(i / columns, i % columns); };
  return Grid<decltype(at(0))>{columns, MapInParallel(config, rows * columns, at)};
}

/// Runs the calibrated asynchronous loop `runs` times. @param change  made to each run's scenario,
/// from several threads. @returns the share of runs that did not succeed.
[[nodiscard]] double FailedShare(const Config& config, int runs,
                                 const std::function<void(scenario::Scenario&)>& change);

/// Passes cycles, or ticks, to a function that takes such records, and drops the others.
///
/// Threads, real-time: as the function, which does not throw.
template <class Function>
class SinkTo final : public record::RecordSink {
 public:
  explicit SinkTo(Function function) : function_(std::move(function)) {}
  void Put(const record::CycleRecord& record) noexcept override { Pass(record); }
  void Put(const record::TickRecord& record) noexcept override { Pass(record); }

 private:
  template <class Record>
  void Pass(const Record& record) noexcept {
    if constexpr (std::is_invocable_v<Function&, const Record&>) function_(record);
  }

  Function function_;
};

/// Records for which a sink has room from the start: on the wall clock a run must not allocate.
/// More than any motion of the experiments has cycles.
inline constexpr std::size_t kMostRecords = 32768;

/// The part of an INT cycle that curves show; names as in RobotState and CycleRecord.
struct CycleSample {
  std::uint64_t message_id = 0;
  JointVector q{};
  JointVector dq{};
  JointVector q_d{};
  JointVector dq_d{};
  JointVector tau_J_d{};
};

/// The part of a tick that wrote a command; names as in TickRecord and RobotCommand.
struct TickSample {
  std::uint64_t message_id = 0;  ///< of the state it answers
  Time deposit_time{};
  JointVector dq_ext{};
  JointVector dq_c{};
  std::optional<double> margin{};
  std::uint8_t kept_back = 0;
};

/// Keeps a run's curves in memory: every cycle in motion, and every tick that wrote.
///
/// Threads: cycles from one, ticks from one; the rest after the run.
class Recording final : public record::RecordSink {
 public:
  Recording();

  void Put(const record::CycleRecord& record) noexcept override;
  void Put(const record::TickRecord& record) noexcept override;

  [[nodiscard]] const std::vector<CycleSample>& cycles() const noexcept { return cycles_; }
  [[nodiscard]] const std::vector<TickSample>& ticks() const noexcept { return ticks_; }

 private:
  std::vector<CycleSample> cycles_;
  std::vector<TickSample> ticks_;
};

/// One joint of the cycles in [begin, end), as a signal of 1 kHz. @param end  at most the number of
/// cycles counts.
[[nodiscard]] std::vector<double> Signal(const std::vector<CycleSample>& cycles,
                                         JointVector CycleSample::*field, std::size_t joint,
                                         std::size_t begin = 0, std::size_t end = SIZE_MAX);

/// Number of cycles in which the plan moves; the first is at the plan's time 0.
[[nodiscard]] std::size_t PlannedCycles(const reference::Trajectory& plan,
                                        const std::vector<CycleSample>& cycles);

/// The delay of a position behind the plan by least squares over all joints, within 100 ms, s.
/// @param field  the position.
[[nodiscard]] double DelayBehind(const reference::Trajectory& plan,
                                 const std::vector<CycleSample>& cycles,
                                 JointVector CycleSample::*field);

/// Root mean square of each joint's error from the plan so delayed, rad.
[[nodiscard]] JointVector RmsError(const reference::Trajectory& plan,
                                   const std::vector<CycleSample>& cycles,
                                   JointVector CycleSample::*field, double delay_s);

/// The plan's velocity at every cycle, joint by joint, rad/s.
[[nodiscard]] std::array<std::vector<double>, kJoints> PlannedVelocities(
    const reference::Trajectory& plan);

}  // namespace twin::experiment
