#pragma once

#include "experiment/statistics.h"
#include "twin/scenario/scenario.h"

namespace twin::experiment {

/// Measurements of one run of a loop.
struct LoopSample {
  std::vector<double> d_EXT_us;     ///< of each command, rising
  std::vector<double> interval_us;  ///< between the ends of two successive reads
  run::CycleCounts counts{};        ///< of the motion
  bool succeeded = false;           ///< the motion reached its goal
  std::string failure{};            ///< why it did not
  // On the wall clock, of the robot's own thread:
  double robot_late_p99_us = 0;      ///< start of a cycle after its deadline
  std::uint64_t robot_overruns = 0;  ///< whole periods it did not get
};

/// Runs a loop and measures it. @throws as RunScenario.
[[nodiscard]] LoopSample SampleLoop(const Config& config, const scenario::Scenario& scenario);

/// The runs of LF, RS, RA: as many of each.
using LoopRuns = std::array<std::vector<LoopSample>, 3>;

/// The scenario of one of kCalibratedLoops for its `run`-th run, with its seed and start phase.
/// @throws InputError as LoadScenario.
[[nodiscard]] scenario::Scenario LoopScenario(const Config& config, std::size_t loop, int run);

/// Runs each calibrated loop Config::seeds times as LoopScenario has it (the bare loop has no
/// phase), one loop after the other. @param stack  catalogue of RS and RA; LF has the config's own.
/// @throws as RunScenario; InputError when a run wrote no command at all.
[[nodiscard]] LoopRuns RunLoops(const Config& config, const run::Catalogue& stack);

/// A row of the paper's Table 1.
struct TableRow {
  const char* name;
  const char* unit;
  std::array<double, 3> paper;    ///< of LF, RS and RA, as in kCalibratedLoops
  std::array<bool, 3> is_fitted;  ///< whether models/experiments is calibrated on it
  double (*of)(const LoopSample& sample);
};

/// d_EXT: median, p99 and largest; unserved cycles.
inline constexpr std::array<TableRow, 4> kTableOne{
    {{"d_EXT, median",
      "ms",
      {0.012, 0.065, 0.013},
      {true, true, true},
      [](const LoopSample& s) { return 1e-3 * Percentile(s.d_EXT_us, 0.5); }},
     {"d_EXT, p99",
      "ms",
      {0.040, 0.137, 0.048},
      {true, true, true},
      [](const LoopSample& s) { return 1e-3 * Percentile(s.d_EXT_us, 0.99); }},
     {"d_EXT, max",
      "ms",
      {0.087, 2.174, 0.141},
      {false, false, false},
      [](const LoopSample& s) { return 1e-3 * s.d_EXT_us.back(); }},
     {"unserved cycles", "%", {0.18, 5.91, 0.41}, {true, false, false}, [](const LoopSample& s) {
        return s.counts.unserved_percent();
      }}}};
inline constexpr std::size_t kMedianLatency = 0;
inline constexpr std::size_t kHighLatency = 1;  ///< p99
inline constexpr std::size_t kLargestLatency = 2;
inline constexpr std::size_t kUnserved = 3;

/// The unserved shares of all three loops over weight and place of the link's late bin, the last
/// one; runs them with few seeds. @pre the link's law is a histogram, as ours is.
[[nodiscard]] Figure LateStatesFigure(const Config& config);

/// The unserved share of the synchronous loop over drift, start phase and load; with few seeds.
[[nodiscard]] Figure SensitivityFigure(const Config& config);

/// The same law of a computation that takes `factor` times as long. @param factor  > 0.
[[nodiscard]] scenario::Delay Scaled(const scenario::Delay& delay, double factor);

}  // namespace twin::experiment
