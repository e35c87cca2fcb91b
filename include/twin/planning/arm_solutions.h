#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "twin/core/joint_vector.h"

namespace twin::planning {

/// All configurations of the arm that put the flange at a pose with a given angle of joint 7. Seven
/// joints for six coordinates leave one free parameter: q7. Closed form, at most eight solutions.
///
/// Given q7, the pose fixes frame 6 and so the wrist W, the intersection of axes 5 and 6. Shoulder
/// S, elbow and W form a triangle with the arm's side lengths, which gives q4, bent either way. Its
/// plane rotates about SW until axis 5 is perpendicular to axis 6: two rotations. Upper arm and
/// plane give the rotation of link 3, R_z(q1) R_y(q2) R_z(q3): two sets of angles. q5 and q6
/// follow.
/// Parametrising by q7 is He and Liu's idea ("Analytical inverse kinematics for Franka Emika
/// Panda", 2021); the derivation is our own. Dimensions: FCI documentation, Denavit-Hartenberg
/// parameters of Panda.
///
/// No limits are applied: angles are in (-pi, pi], q6 in (-pi/2, 3 pi/2].
///
/// Threads: any. Does not allocate.
class ArmSolutions {
 public:
  /// @param O_T_F  flange in the base; rigid. @param q7  rad.
  /// @param q1     used for joint 1 when the upper arm is upright, where only q1 + q3 is
  /// determined.
  ArmSolutions(const Transform& O_T_F, double q7, double q1 = 0) noexcept;

  [[nodiscard]] std::span<const JointVector> all() const noexcept { return {q_.data(), count_}; }

 private:
  std::array<JointVector, 8> q_{};
  std::size_t count_ = 0;
};

}  // namespace twin::planning
