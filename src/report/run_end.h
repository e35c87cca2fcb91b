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

/// What the emulated link drew for the state before a cycle and for its answer.
struct LinkFate {
  bool state_lost = false;
  bool command_lost = false;
  std::optional<Duration> late{};  ///< of a written command after its deadline; <= 0: in time
};

/// A cycle of the robot, and the workstation's answer to the previous state.
struct EndCycle {
  record::CycleRecord cycle;
  std::optional<record::TickRecord> answer;  ///< to state message_id - 1, written or not
  std::optional<LinkFate> link{};            ///< nullopt: not known

  /// True if the workstation wrote a command for the cycle.
  [[nodiscard]] bool written() const { return answer && WroteCommand(*answer); }
};

/// Data from a log about the end of a motion by an error, or about the end of a run without errors.
struct RunEnd {
  /// Cycles kept and shown.
  static constexpr std::size_t kShown = 50;

  record::RunInfo run;
  bool truncated = false;      ///< the run was killed
  bool moved = false;          ///< a motion ran
  bool fates_told = false;     ///< the log has the fate of at least one cycle's command
  bool has_ticks = false;      ///< the log has the workstation's side; a server's log does not
  bool on_robot_time = false;  ///< the workstation's time was the robot's states, not a clock
  std::optional<double> user_stopped;  ///< time at which the user stop ended the motion, s
  double begin = 0;                    ///< time at which the abort's motion began, s
  double end = 0;                      ///< time of the last cycle, s
  record::FilterCounts filter;         ///< of the whole log
  std::uint64_t aborts = 0;            ///< number of motions that an error ended
  std::uint64_t number = 0;            ///< motions of the log up to the abort, or in all
  std::string motion;                  ///< motion of the abort in a session: "motion 2: place"
  std::string last_word;  ///< the log's last event about a motion: "finished", or why not
  /// What the arm touched at the abort, by the simulation (plant::ContactMoment::Text()); empty:
  /// not known.
  std::string contacts;
  /// The limit of the lab that a served robot's guard stopped the motion for, by its server:
  /// "limit \"cell\": the hand reaches ..."; empty: none.
  std::string guard;
  /// kShown cycles up to that of the abort, and the one before them. Empty if no error ended a
  /// motion.
  std::vector<EndCycle> cycles;
  ApproachTracker approach;  ///< of the cycles since the last abort before this one, else of all

  [[nodiscard]] bool aborted() const { return !cycles.empty(); }
  /// True for a log from the workstation's end of a wire with a motion: only the robot knows the
  /// fates of the commands. Without a motion no command was due, so no fate is unknown.
  [[nodiscard]] bool fates_unknown() const { return is_remote() && moved && !fates_told; }
  /// True if the robot was at the other end of a wire, which does not carry the values of errors.
  [[nodiscard]] bool is_remote() const { return run.drive == "remote"; }
  /// The cycle of the error, and the previous one. @pre aborted().
  [[nodiscard]] const record::CycleRecord& last() const { return cycles.back().cycle; }
  [[nodiscard]] const record::CycleRecord& before() const {
    return cycles[cycles.size() < 2 ? 0 : cycles.size() - 2].cycle;
  }
};

/// Reads a log in one pass. @returns one per abort, in their order; without aborts, one for the
/// run. @throws InputError if the log is damaged or has no cycle; EnvironmentError if it cannot be
/// read.
[[nodiscard]] std::vector<RunEnd> ReadEnds(const std::filesystem::path& log);

}  // namespace twin::report
