#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <sys/types.h>

#include "twin/core/robot_errors.h"
#include "twin/record/cycle_record.h"
#include "twin/rt/child_process.h"
#include "twin/run/run.h"

namespace twin::experiment {

/// One motion, as the robot counts it.
struct TalliedMotion {
  std::uint64_t first_id = 0;  ///< of the first cycle with a command
  std::uint64_t last_id = 0;   ///< of the last
  run::CycleCounts counts{};
  RobotErrors errors{};  ///< that ended it; none: it ended in order, or by the client

  /// ", aborted by ..."; empty for an end in order.
  [[nodiscard]] std::string HowItEnded() const;
};

/// Counts the fate of each command in the motions of a robot.
///
/// Threads: cycles from one; the rest after the robot's end. Real-time: Put() allocates nothing;
/// when full it drops cycles and sets is_full().
class MotionTally final : public record::RecordSink {
 public:
  /// Number of successive cycles without a command that ends a motion.
  [[nodiscard]] static std::uint32_t EndsTheMotion() noexcept;

  MotionTally();

  void Put(const record::CycleRecord& record) noexcept override;
  void Put(const record::TickRecord& /*record*/) noexcept override {}

  [[nodiscard]] const std::vector<TalliedMotion>& motions() const noexcept { return motions_; }
  /// Successive cycles without a command up to each cycle of all motions.
  [[nodiscard]] const std::vector<std::uint8_t>& lost_in_row() const noexcept {
    return lost_in_row_;
  }
  [[nodiscard]] bool IsInMotion(std::uint64_t message_id) const noexcept;
  /// Of all motions.
  [[nodiscard]] const run::CycleCounts& counts() const noexcept { return counts_; }
  [[nodiscard]] bool is_full() const noexcept { return is_full_; }

 private:
  static constexpr std::size_t kMotions = 1000;
  static constexpr std::size_t kCycles = std::size_t{1} << 22;  ///< 70 minutes in motion

  std::vector<TalliedMotion> motions_;
  run::CycleCounts counts_;
  std::vector<std::uint8_t> lost_in_row_;
  bool in_motion_ = false;
  bool is_full_ = false;
};

/// Times of a state and its answer in a capture.
struct Answer {
  std::uint64_t message_id = 0;
  double sent_s = 0;      ///< on the capture's time line
  double received_s = 0;  ///< of the first command that answers it
};

/// The answered states of a capture, in the order of their ids. Ids rise as long as a robot runs.
/// @param capture  of a server, pcapng. @throws InputError, EnvironmentError as
/// record::PcapngReader.
[[nodiscard]] std::vector<Answer> AnswersOf(const std::filesystem::path& capture);

/// A shell's command line that runs beside this process, with its standard files, as a process
/// group of its own. When this process reads from a terminal, that group has the foreground
/// meanwhile, so that Ctrl-C ends the client.
///
/// Threads: one.
class ClientProcess {
 public:
  /// @throws EnvironmentError when the shell does not start.
  explicit ClientProcess(const std::string& command);
  /// As End().
  ~ClientProcess();
  ClientProcess(const ClientProcess&) = delete;
  ClientProcess& operator=(const ClientProcess&) = delete;

  /// Whether it has ended by now.
  [[nodiscard]] bool HasEnded();
  /// Asks the group to end, and kills it after a second. Does nothing after its end.
  void End();
  /// "exit code 1", "signal 6". @pre HasEnded().
  [[nodiscard]] std::string HowItEnded() const;

 private:
  /// Gives the terminal's foreground to a process group.
  static void GiveTerminalTo(pid_t group);

  rt::ChildProcess process_;
  std::optional<int> status_;  ///< as wait() has it; absent: it runs
};

}  // namespace twin::experiment
