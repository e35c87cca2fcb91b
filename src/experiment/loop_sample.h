#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "twin/core/time.h"
#include "twin/experiment/experiment.h"
#include "twin/rt/cycle_record.h"
#include "twin/scenario/scenario.h"

namespace twin::experiment {

/// What one run of a loop measured of itself.
struct LoopSample {
  std::vector<double> d_EXT_us;     ///< of each command, rising
  std::vector<double> interval_us;  ///< between the ends of two reads in a row
  double unserved_percent = 0;      ///< of the motion's cycles
  std::uint64_t longest_loss = 0;   ///< most unserved cycles in a row
  std::uint64_t cycles = 0;         ///< of the motion
  bool succeeded = false;           ///< the motion reached its goal
  std::string failure{};            ///< why it did not
  // On the wall clock, of the robot's own thread:
  double robot_late_p99_us = 0;      ///< begin of a cycle after its deadline
  std::uint64_t robot_overruns = 0;  ///< whole periods it did not get
};

/// Runs it and keeps what it measured. @throws as RunScenario.
[[nodiscard]] LoopSample SampleLoop(const Setting& setting, const scenario::Scenario& scenario);

/// The smallest value with at least `share` of all at or below it. @param sorted  rising, not
/// empty. @param share  in [0, 1].
[[nodiscard]] double Percentile(std::span<const double> sorted, double share);

/// Mean of some values, and how far they spread. All 0 for none.
struct Spread {
  double mean = 0;
  double low = 0;
  double high = 0;
};
[[nodiscard]] Spread SpreadOf(std::span<const double> values);

/// Shares of values in bins [edges[i], edges[i + 1]), of all values, in and out of the bins.
/// @param edges  rising, at least two.
[[nodiscard]] std::vector<double> Histogram(std::span<const double> values,
                                            std::span<const double> edges);

/// Shares of values above each edge, of all values; 0 for none.
[[nodiscard]] std::vector<double> Exceedance(std::vector<double> values,
                                             std::span<const double> edges);

/// Edges in equal steps of the logarithm, the first `from`, the last not below `to`.
[[nodiscard]] std::vector<double> LogEdges(double from, double to, int per_decade);

/// The same law of a computation that takes `factor` times as long. @param factor  > 0.
[[nodiscard]] scenario::Delay Scaled(const scenario::Delay& delay, double factor);

}  // namespace twin::experiment
