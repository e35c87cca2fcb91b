#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "application/compliance_cases.h"
#include "twin/core/joint_vector.h"
#include "twin/core/limits.h"
#include "twin/core/time.h"
#include "twin/reference/pose_trajectory.h"

namespace twin::application::compliance {

/// One state of a case's motion.
struct Sample {
  std::uint64_t cycle = 0;  ///< ms since the motion's first state
  double at = 0;            ///< s, of the session
  Vector3 p{};              ///< of the end effector, m
  Vector3 off{};            ///< p - p_d, from its reference, m
  double turned = 0;        ///< from its reference, rad
  Vector3 force{};          ///< on the arm, as the robot estimates it: -O_F_ext_hat_K, N
  double torque = 0;        ///< largest of |tau_J| and |tau_J_d| over their limits, of all joints
  double rate = 0;          ///< largest of |d tau_J_d / dt| over its limit
  JointVector q{};          ///< rad

  /// Since the motion's first state, s.
  [[nodiscard]] double t() const noexcept { return 1e-3 * static_cast<double>(cycle); }
};

/// A case's motion, as the log has it, in order of time, until its last command: the robot stops
/// the arm by itself. Empty: it was not made.
using Trace = std::vector<Sample>;

/// When a case's motion was under way, and what it followed.
struct Span {
  Time begun{};
  Time ended{};
  std::optional<reference::PoseTrajectory> path{};  ///< absent: the pose it began at
};

/// What the log says of the cases, and of the run as a whole.
struct Log {
  std::array<Trace, kCases> traces{};
  std::uint64_t reflexes = 0;  ///< times the robot stopped by itself
};

/// Reads a log. The reference's time is the session's, which is the controller's, since the first
/// state of the motion, in which the controller begins, to about a millisecond. A push's time is
/// the robot's, in cycles: on the wall clock a robot may come to lag.
/// @throws as record::LogReader.
[[nodiscard]] Log ReadLog(const std::filesystem::path& log,
                          const std::array<std::optional<Span>, kCases>& spans,
                          const JointLimits& limits);

}  // namespace twin::application::compliance
