#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "twin/core/time.h"
#include "twin/loop/loop_config.h"
#include "twin/report/plot.h"
#include "twin/run/run.h"

namespace twin::experiment {

/// How a figure of ours compares with what is known about it. Only the first two have a demand.
enum class Verdict : std::uint8_t {
  kPredicted,      ///< follows by mechanism from inputs not fitted to it, and meets its demand
  kNotReproduced,  ///< misses its demand
  kCalibrated,     ///< an input, fitted to the paper's figure
  kReported,       ///< has no demand, or holds by arithmetic
};

/// The verdict in a report's words: "not reproduced". Thread-safe.
[[nodiscard]] std::string_view Name(Verdict verdict) noexcept;

/// Mean, smallest and largest of some values; all 0 without values.
struct Spread {
  double mean = 0;
  double low = 0;
  double high = 0;
};

/// One figure beside the paper's.
struct Comparison {
  std::string quantity{};         ///< "RS, d_EXT, median"
  std::string unit{};             ///< "ms", "%"; empty: a pure number
  std::optional<double> paper{};  ///< absent: the paper has none
  double ours = 0;
  std::optional<double> low{};  ///< smallest over the seeds or runs; absent for a single value
  std::optional<double> high{};
  std::string demand{};  ///< "within 20 % of the paper's"; empty: none
  Verdict verdict = Verdict::kReported;
  std::string reason{};  ///< why it is not reproduced, where known; shown with that verdict

  /// Sets the paper's figure.
  Comparison& Paper(double value);
  /// Sets the demand and its verdict; an empty text sets no demand.
  Comparison& Demand(std::string text, bool met);

  /// Not reproduced, for an unknown reason.
  [[nodiscard]] bool is_missed() const noexcept;

  /// ours / paper; absent without the paper's figure, or when that is 0.
  [[nodiscard]] std::optional<double> ratio() const noexcept;
};

/// A plot of the report: src/report/templates/experiment/EXPERIMENT_FIGURE.gp draws it.
using Figure = report::Figure;

/// The results of an experiment.
struct Findings {
  std::string id{};      ///< the spelling of the command line and of file names: "timings"
  std::string title{};   ///< "Loop timings (Table 1)"
  std::string source{};  ///< place in the paper: "Section 2, Table 1"
  /// Its section of the report: src/report/templates/experiment/PAGE.html. Empty: none.
  std::string page{};
  std::map<std::string, std::string> values{};  ///< texts of the section, by name
  std::vector<Comparison> comparisons{};
  std::vector<Figure> figures{};
  std::string failure{};  ///< why the experiment failed; empty: it completed

  /// Appends a figure of ours. @returns it, until the next call.
  Comparison& Add(std::string quantity, std::string unit, double ours);
  /// Appends a mean with its range. @returns it, until the next call.
  Comparison& Add(std::string quantity, std::string unit, const Spread& spread);

  /// It completed, and missed no demand for an unknown reason.
  [[nodiscard]] bool succeeded() const noexcept;
};

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
  int seeds = 20;             ///< runs per averaged figure, >= 1
  bool is_calibrated = true;  ///< `scenarios` is the shipped folder, not a user's
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
  /// The same with Config::on_wall_clock: timings of this machine, with demands that hold on every
  /// machine. Null: the results do not depend on how a machine keeps time.
  Findings (*run_on_wall_clock)(const Config& config) = nullptr;
};

/// Runs an experiment on the clock that the config names. @returns the findings, with the
/// experiment's names.
[[nodiscard]] Findings Run(const Experiment& experiment, const Config& config);

/// All experiments, in the order of the paper.
[[nodiscard]] std::span<const Experiment> Experiments() noexcept;

/// One of the paper's three loops.
struct CalibratedLoop {
  std::string_view name;  ///< the paper's: "LF"
  std::string_view file;  ///< its scenario, without .yaml
  loop::LoopKind kind{};  ///< the loop that the scenario must name
};

// Places in kCalibratedLoops.
inline constexpr std::size_t kBare = 0;
inline constexpr std::size_t kSynchronous = 1;
inline constexpr std::size_t kAsynchronous = 2;

/// In the paper's order.
inline constexpr std::array<CalibratedLoop, 3> kCalibratedLoops{{
    {"LF", "bare", loop::LoopKind::kBare},
    {"RS", "synchronous", loop::LoopKind::kSynchronous},
    {"RA", "asynchronous", loop::LoopKind::kAsynchronous},
}};

/// Source of the delays of every experiment.
struct Calibration {
  /// 16 hexadecimal digits: FNV-1a over the three scenarios as ToYaml writes them. It changes with
  /// any of their values.
  std::string hash;
  std::array<std::string, 3> yaml;  ///< of the loops, complete
};

/// @param scenarios  Config::scenarios. @throws InputError as scenario::Load.
[[nodiscard]] Calibration ReadCalibration(const std::filesystem::path& scenarios);

/// A user's program, written for the robot.
struct ClientProgram {
  /// Line for /bin/sh; it connects to 127.0.0.1. It inherits the standard files.
  std::string command;
  /// Time after which the experiment ends the program; absent: the program ends by itself.
  std::optional<Duration> most{};
  std::uint16_t arm_port = 1337;         ///< TCP port of the arm; the hand's is the next one
  std::vector<std::byte> model_library;  ///< server::ServerConfig::model_library
};

/// Table 1 for a user's own loop: serves a robot on the wall clock, from the ready pose and without
/// a scene, runs the program until it ends, and measures its timing from outside.
/// d_EXT is taken on the wire: from a state's departure from the server to the arrival of its
/// answer at the kernel; it includes both ways over loopback beside the program's own time.
/// Cycles are counted as INT counts them: unserved, and how many in a row of the 20 that end a
/// motion.
/// @returns figures of all motions together, and of each. Findings::failure names a client without
/// a motion, or one that cannot be started.
/// @throws EnvironmentError when a port is in use; RobotFault when Config::interrupted is set.
[[nodiscard]] Findings RunClientStudy(const Config& config, const ClientProgram& program);

}  // namespace twin::experiment
