#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "twin/core/joint_vector.h"

namespace twin::planning {

/// All configurations of the arm that put the flange at a pose, with joint 7 at a given angle:
/// seven joints for six coordinates leave one free, and q7 runs through what it allows. In closed
/// form, up to eight.
///
/// With q7 the pose fixes frame 6, so the wrist W (where axes 5 and 6 meet). Shoulder S, elbow and
/// W make a triangle whose sides are the arm's: it gives q4, bent either way. Its plane may turn
/// about SW until axis 5 is at right angles to axis 6: two turns. Upper arm and plane are the
/// rotation of link 3, R_z(q1) R_y(q2) R_z(q3): two ways to write it. q5 and q6 follow.
/// The idea to take q7 for the redundancy is He and Liu's ("Analytical inverse kinematics for
/// Franka Emika Panda", 2021); the derivation is ours. Dimensions: FCI documentation,
/// Denavit-Hartenberg parameters of Panda.
///
/// No limits are applied: angles are in (-pi, pi], q6 in (-pi/2, 3 pi/2].
///
/// Threads: any. Allocates nothing.
class ArmSolutions {
 public:
  /// @param O_T_F  flange in the base; rigid. @param q7  rad.
  /// @param q1     taken for joint 1 where the upper arm stands upright, which leaves q1 + q3 alone
  ///               determined.
  ArmSolutions(const Transform& O_T_F, double q7, double q1 = 0) noexcept;

  [[nodiscard]] std::span<const JointVector> all() const noexcept { return {q_.data(), count_}; }

 private:
  std::array<JointVector, 8> q_{};
  std::size_t count_ = 0;
};

}  // namespace twin::planning
