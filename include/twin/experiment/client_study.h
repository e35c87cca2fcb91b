#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "twin/core/time.h"
#include "twin/experiment/experiment.h"

namespace twin::experiment {

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
