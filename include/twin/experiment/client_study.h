#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "twin/core/time.h"
#include "twin/experiment/experiment.h"

namespace twin::experiment {

/// A program of somebody's, made for the robot.
struct ClientProgram {
  /// Line for /bin/sh; it connects to 127.0.0.1. It inherits the standard files.
  std::string command;
  /// Ended after so long, if it has not by then; absent: it ends by itself.
  std::optional<Duration> most{};
  std::uint16_t arm_port = 1337;         ///< TCP port of the arm; the hand's is the next one
  std::vector<std::byte> model_library;  ///< server::ServerConfig::model_library
};

/// Table 1 for a loop of the user's own: serves a robot on the wall clock, from the ready pose and
/// without a scene, runs the program until it ends, and tells from outside how it kept time.
/// d_EXT is taken on the wire: from when a state leaves the server to when the command that answers
/// it is received by the kernel; so it holds both ways over loopback, beside the program's own.
/// Cycles are counted as INT does: unserved, and how many in a row of the 20 that end a motion.
/// @returns figures of all motions together, and of each. A client without any motion, or one that
/// cannot be started, is Findings::failure.
/// @throws EnvironmentError when a port is in use; RobotFault when the setting says it was
/// interrupted.
[[nodiscard]] Findings RunClientStudy(const Setting& setting, const ClientProgram& program);

}  // namespace twin::experiment
