#pragma once

#include <optional>
#include <string>

#include "conformance/step_oracle.h"
#include "twin/core/limits.h"
#include "twin/core/robot_state.h"

// Rules of FCI protocol 5 about the reference that two consecutive states show. Each function looks
// for the first breach; nothing: the rule holds. Relations between exact quantities are compared
// within rounding, limits with INT's relative tolerance of 1e-9.
namespace twin::test {

using Finding = std::optional<std::string>;

/// Every number of a state is finite.
[[nodiscard]] Finding FindNotFinite(const RobotState& state);

/// What a state tells twice agrees: O_T_EE_d is the pose at q_d and O_dP_EE_d its velocity, O_T_EE
/// the pose at q, elbows are those of q and q_d, F_T_EE = F_T_NE NE_T_EE, dtau_J is the difference
/// of tau_J.
[[nodiscard]] Finding FindInconsistency(const RobotState& before, const RobotState& after);

/// The joints' reference is `step`.
[[nodiscard]] Finding FindOffStep(const JointMotion& step, const RobotState& after);
/// The commanded pose, twist, acceleration and elbow are those of `step`.
[[nodiscard]] Finding FindOffStep(const CartesianMotion& step, const RobotState& after);

/// The joints' reference moved as its own velocity and acceleration say.
[[nodiscard]] Finding FindBrokenDifferences(const RobotState& before, const RobotState& after);

/// The largest magnitude that the velocity of a step from q may have in the direction of dq, rad/s:
/// an FR3's shrinks towards the ends of the range.
[[nodiscard]] double FastestFrom(double q, double dq, const JointLimits& limits, std::size_t joint);

/// Position, velocity, acceleration and jerk of the joints' reference are within the limits.
[[nodiscard]] Finding FindBeyondLimits(const RobotState& before, const RobotState& after,
                                       const JointLimits& limits);

/// The reference rests where it was: q_d as before, no velocity, no acceleration, of joints, pose
/// and elbow; what is commanded is what is desired.
[[nodiscard]] Finding FindUnrest(const RobotState& before, const RobotState& after);

/// One cycle of coming to rest within the limits of acceleration and jerk.
/// @param took_over  the acceleration began anew at zero (an external torque drove the arm).
[[nodiscard]] Finding FindBadBraking(const RobotState& before, const RobotState& after,
                                     const JointLimits& limits, bool took_over);

/// A reference at rest shows neither velocity nor acceleration.
[[nodiscard]] bool IsAtRest(const RobotState& state);

/// Cycles within which a reference that moves as `state` shows must have come to rest.
[[nodiscard]] int LongestBraking(const RobotState& state, const JointLimits& limits);

}  // namespace twin::test
