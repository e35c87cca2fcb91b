#pragma once

#include <cstdint>

#include "twin/core/joint_vector.h"
#include "twin/core/limits.h"
#include "twin/core/realtime.h"
#include "twin/onboard/cartesian_reference.h"
#include "twin/onboard/violations.h"

// Checks of the commands of a Cartesian motion generator, before inverse kinematics. A NaN violates
// every check. Source: FCI protocol 5, error table and conditions.
//
// Threads: any. Real-time: noexcept, allocates nothing. The axis of a violation is 0 for the
// translation, 1 for the rotation, 2 for the elbow; frame and sign have none.
namespace twin::onboard {

/// Checks that the pose is a rigid transform (IsRigid, core/setting.h), else
/// cartesian_position_motion_generator_invalid_frame. Its value is the largest deviation of the
/// columns' products, the determinant or the last row. Clients check less (the norms).
[[nodiscard]] Violations CheckFrame(const Transform& O_T_EE_c,
                                    std::uint64_t message_id) noexcept TWIN_REALTIME;

/// Largest distances between a motion's first command and the reference.
struct StartTolerance {
  double translation_m = 0;
  double rotation_rad = 0;
  double elbow_rad = 0;
};

/// Checks that a motion's first pose is near the reference, in translation and rotation, else
/// cartesian_position_motion_generator_start_pose_invalid.
[[nodiscard]] Violations CheckStartPose(const Transform& O_T_EE_c, const Transform& O_T_EE_last,
                                        const StartTolerance& tolerance,
                                        std::uint64_t message_id) noexcept TWIN_REALTIME;

/// Checks that the first commanded elbow is near the last one, else
/// cartesian_motion_generator_start_elbow_invalid.
[[nodiscard]] Violations CheckStartElbow(double elbow_c, double elbow_last,
                                         const StartTolerance& tolerance,
                                         std::uint64_t message_id) noexcept TWIN_REALTIME;

/// Checks that the commanded sign is the arm's (-1 or +1 wherever a Cartesian motion can run), else
/// cartesian_motion_generator_elbow_sign_inconsistent with the commanded sign as its value.
[[nodiscard]] Violations CheckElbowSign(double sign_c, double sign,
                                        std::uint64_t message_id) noexcept TWIN_REALTIME;

/// Checks one step of a Cartesian reference against the limits: Euclidean norms of translation and
/// rotation, and the magnitude of the elbow.
///
/// Precedence: discontinuity before envelope, as in CheckStep: acceleration and jerk separately,
/// then velocity and the elbow's range. Each error is reported with its first axis.
///
/// @param has_elbow  an elbow is commanded; else joint 3 is only checked after inverse kinematics.
/// @param joints     limits of joint 3, which bound the elbow.
[[nodiscard]] Violations CheckCartesianStep(const CartesianReference& next, bool has_elbow,
                                            const CartesianLimits& limits,
                                            const JointLimits& joints,
                                            std::uint64_t message_id) noexcept TWIN_REALTIME;

}  // namespace twin::onboard
