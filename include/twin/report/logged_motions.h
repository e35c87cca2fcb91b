#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "twin/core/modes.h"
#include "twin/core/robot_errors.h"
#include "twin/core/time.h"
#include "twin/record/log_records.h"

namespace twin::report {

/// A motion of a robot, from the log of a session.
struct LoggedMotion {
  MotionGeneratorMode generator{};
  ControllerMode controller{};
  Time begin{};        ///< the first cycle in mode Move
  Time end{};          ///< the last one
  std::string client;  ///< that led it, "127.0.0.1:4033"; empty: the log does not say
  /// As the robot's server told it: "finished", "stopped", "aborted by reflex: ..."; of a log
  /// without: "ended", or the names of its errors.
  std::string how;
  RobotErrors errors;              ///< that ended it
  bool is_user_stopped = false;    ///< the user stop ended it
  std::uint64_t served = 0;        ///< cycles with a command in time
  std::uint64_t held = 0;          ///< cycles without one
  std::uint32_t longest_loss = 0;  ///< most held cycles in a row
  /// Largest magnitude of q_d - q of any joint, rad; absent under torques, where the robot has no
  /// reference.
  std::optional<double> peak_error{};
  /// Largest magnitude of dq of any joint, rad/s.
  double peak_speed = 0;

  [[nodiscard]] bool is_aborted() const noexcept { return errors.any() || is_user_stopped; }
};

/// The motions and events of a log.
struct LoggedSession {
  std::vector<LoggedMotion> motions;        ///< by time
  std::vector<record::EventRecord> events;  ///< by time
};

/// Reads the log of a served robot (run::ToldEvents), complete or not, in one pass.
///
/// Threads: one thread. Real-time: no. @throws as record::LogReader.
[[nodiscard]] LoggedSession ReadSession(const std::filesystem::path& log);

}  // namespace twin::report
