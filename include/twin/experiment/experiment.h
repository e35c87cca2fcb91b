#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string_view>

#include "twin/experiment/findings.h"
#include "twin/run/run.h"

namespace twin::experiment {

/// What an experiment works with.
struct Setting {
  const run::Catalogue& catalogue;
  run::RunFiles files;
  /// Folder of the experiments' scenarios: the calibrated loops and the motions. Source of every
  /// delay in them: Table 1 of the paper, and nothing else. A user's own may stand instead.
  std::filesystem::path scenarios;
  /// For what runs write on the way; the caller's to remove.
  std::filesystem::path scratch;
  std::uint64_t seed = 1;
  int seeds = 20;             ///< runs of what is averaged, >= 1
  bool is_calibrated = true;  ///< `scenarios` are ours; false: somebody's own, of another loop
  /// Runs take place on the wall clock, one after the other, over UDP on this machine against a
  /// robot served from this process; else on the virtual clock.
  bool on_wall_clock = false;
  /// Told now and then: share done, in [0, 1]. May be empty.
  std::function<void(double share)> progress;
  /// As RunHooks::interrupted. An experiment that sees it set throws RobotFault.
  const volatile bool* interrupted = nullptr;
};

/// One of the paper's tables or figures. On the virtual clock the same setting gives the same
/// bytes, and runs of one experiment may be worked off on several threads.
struct Experiment {
  std::string_view id;      ///< "timings"
  std::string_view title;   ///< "Loop timings (Table 1)"
  std::string_view source;  ///< "Section 2, Table 1"
  /// @throws InputError and EnvironmentError as the runs do; the caller turns them into a failure
  /// of this experiment, and goes on with the next.
  Findings (*run)(const Setting& setting);
  /// The same with Setting::on_wall_clock: what this machine makes of it, and what must hold on
  /// any. Null: nothing in it hangs on how a machine keeps time.
  Findings (*run_on_wall_clock)(const Setting& setting) = nullptr;
};

/// Runs an experiment on the drive of the setting. @returns what `run` found, under its names.
[[nodiscard]] Findings Run(const Experiment& experiment, const Setting& setting);

/// All of them, in the order of the paper.
[[nodiscard]] std::span<const Experiment> Experiments() noexcept;

}  // namespace twin::experiment
