#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "twin/core/error_catalogue.h"
#include "twin/core/robot_errors.h"
#include "twin/core/time.h"
#include "twin/faults/message_fate.h"

namespace twin::report {

/// The error that an explanation is about.
struct ExplainedError {
  Violation violation;       ///< of a log without the value: the error alone
  bool has_value = false;    ///< axis, value and limit are known
  std::uint64_t cycle = 0;   ///< id of the robot state of the cycle that raised it
  Time at{};                 ///< of the run
  std::uint64_t motion = 0;  ///< that the error ended, counted from 1 over the log
};

/// Explanation of a run's end.
struct Explanation {
  bool aborted = false;  ///< an error ended a motion
  /// The first error of the motion that `text` is about; nullopt unless aborted.
  std::optional<ExplainedError> error{};
  /// Text for a terminal, in lines of at most 100 columns: the error and its place; value, limit
  /// and derivation of the value; fate of the last commands, and whether losses may have caused the
  /// error; what the arm touched, joints at an end stop; usual cause and cure. A log from the
  /// workstation's end of a wire has neither the fates nor the value; the text then says so. For a
  /// run without an error: how close the run came to each limit.
  std::string text;
  /// All errors of the log, the first kMostOnPage and the one in `text`, as a self-contained HTML
  /// page, with plots and numbers of the last 50 cycles before each. Empty unless aborted, and
  /// when only the text was asked for.
  std::string page;

  static constexpr std::size_t kMostOnPage = 20;
};

/// The emulated link between robot and workstation, which draws the fate of each message from a
/// seed.
struct LinkFacts {
  std::uint64_t seed = 0;
  faults::DirectionConfig state;
  faults::DirectionConfig command;
  Duration d_INT{};  ///< time before a cycle by which its command must have arrived
};

/// A push, or a hand's spring, that the scenario scripts.
struct ScriptedForce {
  std::string what;  ///< "pushes panda_hand with 30 N"
  double begin = 0;  ///< s
  double end = 0;    ///< s
  /// Number of the motion since whose begin the times count; nullopt: since the run's.
  std::optional<std::uint64_t> motion{};
};

/// What a run's scenario sets, as far as it explains an error or is advised against one.
struct ScenarioFacts {
  double target_noise = 0;     ///< largest, on every target, in the unit of what was commanded
  bool has_generator = false;  ///< a reference generator is between the targets and the robot
  bool has_default_generator = false;   ///< and it is that of scenarios without tick.generator
  bool has_viability = false;           ///< a viability filter is
  bool has_limiter = false;             ///< the rate limiter is
  std::vector<ScriptedForce> forces{};  ///< on bodies
  std::optional<LinkFacts> link{};
};

/// What helps against an error in this scenario: its remedy for this clock, without what the
/// scenario sets already. @param any_lost  commands were lost before.
[[nodiscard]] std::string RemedyIn(const ScenarioFacts& facts, const Violation& violation,
                                   TimeKeeper keeper, bool any_lost);

enum class ExplanationParts : std::uint8_t { kTextAndPage, kText };

/// Explains an error of a log, which may be that of a killed run. The same log gives the same
/// bytes, with the same version of gnuplot.
///
/// Threads: one thread. Not real-time: for the page of an aborted run it runs gnuplot from PATH and
/// waits.
/// @param log  written by record::Recorder. @param facts  of its scenario; nullopt: not known.
/// @param motion  the errors of this motion, counted from 1 over the log; nullopt: the first error.
/// @throws InputError if the log is damaged, has no cycle, or is that of a run killed before any
/// error, and if no error ended `motion`; EnvironmentError if the log cannot be read, or gnuplot is
/// missing or fails.
[[nodiscard]] Explanation Explain(const std::filesystem::path& log,
                                  const std::optional<ScenarioFacts>& facts = std::nullopt,
                                  std::optional<std::uint64_t> motion = std::nullopt,
                                  ExplanationParts parts = ExplanationParts::kTextAndPage);

}  // namespace twin::report
