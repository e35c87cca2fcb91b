#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "report/approach.h"
#include "twin/record/cycle_record.h"
#include "twin/record/log_records.h"

namespace twin::report {

/// Whether the workstation wrote a command in this tick.
[[nodiscard]] inline bool WroteCommand(const record::TickRecord& tick) {
  return tick.action == record::TickAction::kWritten ||
         tick.action == record::TickAction::kFinished;
}

/// A cycle of the robot beside what the workstation had answered to the state before it.
struct EndCycle {
  record::CycleRecord cycle;
  std::optional<record::TickRecord> answer;  ///< to state message_id - 1, written or not

  /// Whether the workstation wrote a command that could count for the cycle.
  [[nodiscard]] bool written() const { return answer && WroteCommand(*answer); }
};

/// What of a log tells how its run ended.
struct RunEnd {
  /// Cycles that are kept and shown.
  static constexpr std::size_t kShown = 50;

  record::RunInfo run;
  bool truncated = false;      ///< the run was killed
  bool moved = false;          ///< a motion ran
  bool fates_told = false;     ///< of some cycle the log tells what became of its command
  bool has_ticks = false;      ///< the log holds the workstation's side; a server's does not
  bool on_robot_time = false;  ///< the workstation counted states instead of a clock
  std::optional<double> user_stopped;  ///< when the user stop ended the motion, s
  double end = 0;                      ///< time of the last cycle, s
  std::uint64_t aborts = 0;            ///< motions that an error ended
  std::string motion;     ///< of a session: "motion 2: place", in which the first abort came
  std::string last_word;  ///< the log's last event about a motion: "finished", or why not
  /// Up to the first abort, its cycle last: kShown cycles, and the one before them. Empty when no
  /// error ended a motion.
  std::vector<EndCycle> cycles;
  ApproachTracker approach;  ///< of the cycles before the first abort, or of all

  [[nodiscard]] bool aborted() const { return !cycles.empty(); }
  /// A log from the workstation's end of a wire: motions ran, and only the robot knows which of
  /// their commands counted. Without a motion no command was due, and that is known.
  [[nodiscard]] bool fates_unknown() const { return is_remote() && moved && !fates_told; }
  /// Whether the robot was at the other end of a wire, which carries no figures of errors.
  [[nodiscard]] bool is_remote() const { return run.drive == "remote"; }
  /// The cycle that the error ended, and the one before it. @pre aborted().
  [[nodiscard]] const record::CycleRecord& last() const { return cycles.back().cycle; }
  [[nodiscard]] const record::CycleRecord& before() const {
    return cycles[cycles.size() < 2 ? 0 : cycles.size() - 2].cycle;
  }
};

/// Reads a log in one pass. @throws InputError when it is damaged or holds no cycle;
/// EnvironmentError when it cannot be read.
[[nodiscard]] RunEnd ReadEnd(const std::filesystem::path& log);

}  // namespace twin::report
