#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string_view>
#include <vector>

#include "twin/core/random.h"
#include "twin/experiment/experiment.h"
#include "twin/rt/cycle_record.h"
#include "twin/run/run.h"
#include "twin/scenario/scenario.h"

namespace twin::experiment {

/// What experiments choose at random: seeds and start phases. Apart from all streams of a run.
inline constexpr RandomStream kExperimentStream{2000};

/// @throws RobotFault when the setting says it was interrupted.
void ThrowIfInterrupted(const Setting& setting);

/// Seed of the `run`-th run of an experiment, from the setting's.
[[nodiscard]] std::uint64_t SeedOfRun(const Setting& setting, int run) noexcept;

/// Uniform in [0, 1), from the setting's seed: `what`-th choice of the `run`-th run.
[[nodiscard]] double ChoiceOfRun(const Setting& setting, int run, std::uint32_t what = 0) noexcept;

/// The setting with other backends and controllers, which must outlive what is returned.
[[nodiscard]] Setting With(const Setting& setting, const run::Catalogue& catalogue);

/// `name`.yaml of the setting's scenarios, without log and video. @throws InputError as Load.
[[nodiscard]] scenario::Scenario LoadScenario(const Setting& setting, std::string_view name);

/// Makes every delay a constant, without drift, the states half a period after the wake-ups; what
/// is lost stays as it is.
void TakeOutTimingFaults(scenario::Scenario& scenario);

/// Runs it, in lockstep or as RunOverWire. How it ended is in the result. @param sink  may be null.
/// @throws as run::Run; RobotFault when the setting says it was interrupted.
run::RunResult RunScenario(const Setting& setting, const scenario::Scenario& scenario,
                           rt::RecordSink* sink);

/// Works off job(0) ... job(count - 1) on the host's processors, on the wall clock one by one; of
/// those that throw the first in their order is thrown, once all are done. Tells the setting how
/// much of `[from, to]` is done, from the calling thread only. @param job  called from several
/// threads at a time.
void InParallel(const Setting& setting, int count, const std::function<void(int)>& job,
                double from = 0, double to = 1);

/// Runs the calibrated asynchronous loop, on as many processors as there are, `runs` times.
/// @param change  of each run's scenario, called from several threads. @param from, to  as
/// InParallel. @returns how many did not end well.
[[nodiscard]] int CountFailures(const Setting& setting, int runs,
                                const std::function<void(scenario::Scenario&)>& change, double from,
                                double to);

}  // namespace twin::experiment
