#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace twin::scenario {

/// A number and what stands behind it in a file: "0.5 %" is 0.5 and "%"; without a unit empty.
struct SweepNumber {
  double value = 0;
  std::string unit;
};

/// From one number to another, both included, in one unit.
struct SweepRange {
  SweepNumber from;
  SweepNumber to;
  std::uint64_t steps = 0;  ///< of a grid, in [2, 10000]; 0: the range is sampled, see SweepSamples
  bool is_logarithmic = false;
};

/// A distribution from which each run draws its own value.
struct SweepDraw {
  bool is_normal = false;
  SweepNumber first;   ///< of a uniform one the least, of a normal one the mean
  SweepNumber second;  ///< the greatest, the standard deviation
};

/// What is varied: exactly one of values, range and draw.
struct SweepAxis {
  std::string key;                  ///< of the scenario, from its root, dotted: "link.command_loss"
  std::vector<std::string> values;  ///< each as YAML in one line
  std::vector<std::string> names;   ///< of the values, in files and pages; empty: as they are
  std::optional<SweepRange> range;
  std::optional<SweepDraw> draw;
};

/// Runs of a scenario at many points, each with many seeds. A point is one value of every axis that
/// is not drawn: of the grid of all combinations, the last axis changing fastest, or of samples
/// (`samples`), in which the ranges are sampled together: a Latin hypercube, or a Sobol sequence.
///
///     name: losses
///     description: How often the motion aborts.
///     scenario: canonical.yaml     # beside this file, else in the models folder
///     axes:
///       - {key: link.command_loss, values: [0 %, 1 %, 2 %]}
///       - {key: tick, values: {ours: {}, paper: {generator: joint, viability: off}}}   # named
///       - {key: plant.mass_scale, from: 0.8, to: 1.2, steps: 5, scale: linear}   # or log
///       - {key: robot.clock_drift, uniform: {from: -20 ppm, to: 20 ppm}}
///       - {key: tick.lambda, normal: {mean: 0.01, deviation: 0.001}}
///     samples: {kind: latin_hypercube, points: 64}   # or sobol; absent: a grid
///     seed: 1                      # of what the sweep draws
///     seeds: 50                    # runs of each point
///     first_seed: 1                # of the first run; the others count on
///     keep: failures               # their logs; absent: summary, no logs; all: of every run
///     stop_at_width: 0.1           # absent: all seeds are run
///     demand: {success: 95 %}      # absent: none
///     budget: 10000                # absent: as many runs as there are
struct SweepFile {
  /// Of which runs logs are kept.
  enum class Keep : std::uint8_t { kSummary, kFailures, kAll };

  std::string name;  ///< letters, digits, '_' and '-'
  std::string description;
  std::filesystem::path scenario;        ///< as the file names it
  std::vector<SweepAxis> axes;           ///< at least one; no key twice
  std::optional<std::uint64_t> samples;  ///< points of the samples, in [1, 10^6]; none: a grid
  bool has_sobol_samples = false;        ///< else those of a Latin hypercube
  std::uint64_t seed = 1;
  std::uint64_t seeds = 1;  ///< in [1, 10^6]
  std::uint64_t first_seed = 1;
  Keep keep = Keep::kSummary;
  /// A point ends early when, after every tenth of its seeds, the 95 % confidence interval of its
  /// share of failures is narrower than this; in [0.001, 1].
  std::optional<double> stop_at_width;
  std::optional<double> least_success_percent;  ///< `demand`, over all runs
  std::optional<std::uint64_t> budget;          ///< greatest number of runs
  std::filesystem::path folder;                 ///< of the file
};

/// Threads: any. @throws InputError "<file>:<line>: <key>: ..." for anything invalid.
[[nodiscard]] SweepFile LoadSweep(const std::filesystem::path& path);

}  // namespace twin::scenario
