#pragma once

#include <cstdint>

#include "conformance/verdict.h"
#include "twin/core/limits.h"
#include "twin/core/modes.h"
#include "twin/core/robot_state.h"
#include "twin/core/setting.h"

namespace twin::test {

/// What INT compares commands with.
struct OracleLimits {
  JointLimits joints;
  CartesianLimits cartesian;
  double start_q_rad = 0.1;
  double start_translation_m = 0.05;
  double start_rotation_rad = 0.1;
  double start_elbow_rad = 0.1;
  std::uint32_t abort_after_lost = 20;
  std::uint32_t first_command_timeout_cycles = 1000;
};

/// One step of a joint reference with its difference quotients.
struct JointMotion {
  JointVector q{};
  JointVector dq{};
  JointVector ddq{};
  JointVector dddq{};
};

/// One step of a commanded pose and elbow with their difference quotients.
struct CartesianMotion {
  Transform pose = kIdentityTransform;
  Vector6 twist{};
  Vector6 acceleration{};
  Vector6 jerk{};
  double oblique = 0;      ///< by how much the rotations it comes of are none
  bool has_elbow = false;  ///< the elbow is commanded, not left to the robot
  double elbow = 0;
  double delbow = 0;
  double ddelbow = 0;
  double dddelbow = 0;
};

/// Backward differences over 1 ms on what the last state showed, as FCI protocol 5 tells them; the
/// commands after the robot's own low-passes.
[[nodiscard]] JointMotion JointStep(const RobotState& before, const RobotCommand& command,
                                    MotionGeneratorMode mode, const setting::Filters& filters);
[[nodiscard]] CartesianMotion CartesianStep(const RobotState& before, const RobotCommand& command,
                                            MotionGeneratorMode mode,
                                            const setting::Filters& filters);
/// The same without a command: accelerations are held.
[[nodiscard]] JointMotion HeldJointStep(const RobotState& before);
[[nodiscard]] CartesianMotion HeldCartesianStep(const RobotState& before, bool has_elbow);
/// The step to given joint positions.
[[nodiscard]] JointMotion JointStepTo(const RobotState& before, const JointVector& q);
/// One cycle of standing still after `motion`.
[[nodiscard]] JointMotion Standing(const JointMotion& motion);
[[nodiscard]] CartesianMotion Standing(const CartesianMotion& motion);

/// Commanded torque after its low-pass.
[[nodiscard]] JointVector TorqueStep(const RobotState& before, const RobotCommand& command,
                                     const setting::Filters& filters);

/// The errors of joint motion generators (12-15) that a step must and may raise.
[[nodiscard]] Verdict JudgeJoints(const JointMotion& step, const JointLimits& limits);
/// Those of Cartesian ones before inverse kinematics (17-20).
[[nodiscard]] Verdict JudgeCartesian(const CartesianMotion& step, const OracleLimits& limits);
/// Those after inverse kinematics (27-30). @param noise  of the joint positions, rad.
[[nodiscard]] Verdict JudgeCompletion(const JointMotion& step, const JointLimits& limits,
                                      double noise);
/// Torque rate (32).
[[nodiscard]] Verdict JudgeTorque(const JointVector& tau_d, const RobotState& before,
                                  const JointLimits& limits);
/// What a command is refused for before its motion is looked at: no frame (31), start pose and
/// start elbow (11, 16, 22; of what the low-passes leave), elbow sign (21), in this order.
/// @param had_elbow  the command before had an elbow.
[[nodiscard]] Verdict JudgeShape(const RobotState& before, const RobotCommand& command,
                                 MotionGeneratorMode mode, bool is_first, bool had_elbow,
                                 const setting::Filters& filters, const OracleLimits& limits);

}  // namespace twin::test
