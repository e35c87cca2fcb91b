#pragma once

#include <optional>
#include <string>

#include "conformance/verdict.h"
#include "twin/core/limits.h"
#include "twin/core/robot_state.h"
#include "twin/core/setting.h"

namespace twin::test {

/// Bounds of what the robot measures, as told to INT.
struct MeasuredLimits {
  JointVector q_min{};
  JointVector q_max{};
  JointVector dq_max{};
  double translation_max = 0;  ///< m/s
  double rotation_max = 0;     ///< rad/s, in Cartesian motions
  JointVector tau_J_max{};
  double power_max = 0;  ///< W
  double clearance = 0;  ///< m
  bool has_hand = false;
};

/// What the robot must and may stop for by what `last` shows of collisions (6, 7).
[[nodiscard]] Verdict JudgeCollisions(const RobotState& last,
                                      const setting::CollisionBehavior& behavior);

/// What a motion must and may be aborted for by what `last` shows to be measured: joint position
/// (0) and velocity (3), Cartesian velocity (4), power (26), tau_J range (34).
[[nodiscard]] Verdict JudgeMeasured(const RobotState& last, const MeasuredLimits& limits,
                                    bool is_cartesian);

/// The same for links that come too close (2), by ArmOracle's distance.
[[nodiscard]] Verdict JudgeSelfCollision(const RobotState& last, const MeasuredLimits& limits);

/// Whether a joint is where only people may get it out.
[[nodiscard]] bool IsOutOfRange(const JointVector& q, const MeasuredLimits& limits);

/// Whether contact and collision flags are what the external torques and forces of `s` make them.
/// @returns a text when they are not.
[[nodiscard]] std::optional<std::string> FindWrongFlags(const RobotState& before,
                                                        const RobotState& s,
                                                        const setting::CollisionBehavior& behavior);

/// Whether the external wrench is what the external torque makes it: J (tau - J^T F) = 0 at K, K_F
/// the same in K axes; zero only where the arm is nearly singular.
[[nodiscard]] std::optional<std::string> FindWrongWrench(const RobotState& s);

}  // namespace twin::test
