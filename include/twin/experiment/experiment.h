#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string_view>

#include "twin/experiment/findings.h"
#include "twin/run/run.h"

namespace twin::experiment {

/// The inputs of an experiment.
struct Config {
  std::reference_wrapper<const run::Catalogue> catalogue;
  run::RunFiles files;
  /// Folder of the experiments' scenarios: the calibrated loops and the motions. Their delays come
  /// from Table 1 of the paper alone. A user may give another folder.
  std::filesystem::path scenarios;
  /// Folder for intermediate files; the caller removes it.
  std::filesystem::path scratch;
  std::uint64_t seed = 1;
  int seeds = 20;  ///< runs per averaged figure, >= 1
  bool is_calibrated =
      true;  ///< `scenarios` is the shipped folder; false: a user's, of other loops
  /// Runs take place on the wall clock, one after the other, over UDP on this machine against a
  /// robot served by this process; else on the virtual clock.
  bool on_wall_clock = false;
  /// Receives the share done, in [0, 1], from the calling thread. May be empty.
  std::function<void(double share)> progress;
  /// As RunHooks::interrupted. An experiment that sees it set throws RobotFault.
  const volatile bool* interrupted = nullptr;
};

/// One of the paper's tables or figures. On the virtual clock the same config gives the same bytes;
/// the runs of one experiment may share several threads.
struct Experiment {
  std::string_view id;      ///< "timings"
  std::string_view title;   ///< "Loop timings (Table 1)"
  std::string_view source;  ///< "Section 2, Table 1"
  /// @throws InputError and EnvironmentError as the runs; the caller reports them as a failure of
  /// this experiment and continues with the next.
  Findings (*run)(const Config& config);
  /// The same with Config::on_wall_clock: what this machine makes of it, with demands that hold on
  /// every machine. Null: the results do not depend on how a machine keeps time.
  Findings (*run_on_wall_clock)(const Config& config) = nullptr;
};

/// Runs an experiment on the clock that the config names. @returns the findings, with the
/// experiment's names.
[[nodiscard]] Findings Run(const Experiment& experiment, const Config& config);

/// All experiments, in the order of the paper.
[[nodiscard]] std::span<const Experiment> Experiments() noexcept;

}  // namespace twin::experiment
