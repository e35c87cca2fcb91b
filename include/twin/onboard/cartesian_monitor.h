#pragma once

#include <cstdint>

#include "twin/core/joint_vector.h"
#include "twin/core/limits.h"
#include "twin/core/realtime.h"
#include "twin/onboard/cartesian_reference.h"
#include "twin/onboard/violations.h"

// The checks of what a Cartesian motion generator is commanded, before inverse kinematics. What is
// no number breaks every one of them. Source: FCI protocol 5, error table and conditions.
//
// Threads: any. Real-time: noexcept, allocates nothing. The axis of a violation is 0 for the
// translation, 1 for the rotation, 2 for the elbow; frame and sign have none.
namespace twin::onboard {

/// Is the pose a rigid transform (IsRigid, core/setting.h)? Else
/// cartesian_position_motion_generator_invalid_frame with the largest deviation of the columns'
/// products, of the determinant or of the last row as its value. Clients check less (the norms).
[[nodiscard]] Violations CheckFrame(const Transform& O_T_EE_c,
                                    std::uint64_t message_id) noexcept TWIN_REALTIME;

/// Largest distances of a motion's first command from the reference.
struct StartTolerance {
  double translation_m = 0;
  double rotation_rad = 0;
  double elbow_rad = 0;
};

/// Is a motion's first pose near the reference? Else
/// cartesian_position_motion_generator_start_pose_invalid: origins apart, or rotations.
[[nodiscard]] Violations CheckStartPose(const Transform& O_T_EE_c, const Transform& O_T_EE_last,
                                        const StartTolerance& tolerance,
                                        std::uint64_t message_id) noexcept TWIN_REALTIME;

/// Is the first commanded elbow near the last one? Else
/// cartesian_motion_generator_start_elbow_invalid.
[[nodiscard]] Violations CheckStartElbow(double elbow_c, double elbow_last,
                                         const StartTolerance& tolerance,
                                         std::uint64_t message_id) noexcept TWIN_REALTIME;

/// Is the commanded sign the arm's (which is -1 or +1 wherever a Cartesian motion can run)? Else
/// cartesian_motion_generator_elbow_sign_inconsistent with the commanded sign as its value.
[[nodiscard]] Violations CheckElbowSign(double sign_c, double sign,
                                        std::uint64_t message_id) noexcept TWIN_REALTIME;

/// Checks one step of a Cartesian reference against the limits: Euclidean norms of translation and
/// rotation, and the magnitude of the elbow.
///
/// Precedence: discontinuity before envelope, as CheckStep does for joints: acceleration and jerk
/// each by its own cause, then velocity and the elbow's range. Of each error the first axis.
///
/// @param has_elbow  an elbow is commanded; else joint 3 is judged after inverse kinematics alone.
/// @param joints     the elbow's range is that of joint 3.
[[nodiscard]] Violations CheckCartesianStep(const CartesianReference& next, bool has_elbow,
                                            const CartesianLimits& limits,
                                            const JointLimits& joints,
                                            std::uint64_t message_id) noexcept TWIN_REALTIME;

}  // namespace twin::onboard
