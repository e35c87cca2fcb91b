#pragma once

#include <optional>

#include "conformance/step_oracle.h"
#include "twin/core/joint_vector.h"

// Kinematic completion, once more: joint positions from a commanded pose, away from singularities,
// by Newton's method on the exact equations.
namespace twin::test {

/// Smallest singular value of the Jacobian of the flange, m and rad, of all joints or of all but
/// joint 3.
[[nodiscard]] double SmallestSingularValue(const JointVector& q, bool joint_3_moves);

/// Whether nothing near a singularity changes what inverse kinematics gives here: singular values
/// well above where INT damps, joint 4 well away from its flip angle.
[[nodiscard]] bool IsRegular(const JointVector& q, bool joint_3_moves);

/// The joint positions next to q_d at which EE is at `pose`, and joint 3 at `elbow` if given; else
/// those at the least distance from q_d.
[[nodiscard]] JointVector Complete(const JointVector& q_d, const Transform& F_T_EE,
                                   const Transform& pose, const std::optional<double>& elbow);

/// How far Complete() and INT's own completion may be apart after one cycle, rad. Both reach the
/// pose; of the joint motions that do, INT takes the smallest by the Jacobian where the arm would
/// be without acceleration, |ddq| T^2 beside the one that counts here. Where the arm is regular
/// that turns a step of |dq| T by no more than its product with the step.
[[nodiscard]] double CompletionNoise(const JointMotion& step);

}  // namespace twin::test
