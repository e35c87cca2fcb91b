#pragma once

#include "conformance/dice.h"
#include "twin/core/modes.h"
#include "twin/core/robot_state.h"

namespace twin::campaign {

/// What a client of a session commands in a motion: from where it began one joint, or the end
/// effector along z, goes out and comes back within a drawn number of cycles,
///   q_c(x) = q_0 + L 64 x^3 (1 - x)^3,   x from 0 to 1,
/// at rest at both ends, with less than a third of the robot's limits; or it stands still. Torques
/// hold the arm.
class SessionPath {
 public:
  /// @param state  in which the motion shows. @param modes  the motion's.
  SessionPath(test::Dice& dice, const RobotState& state, const MotionModes& modes);

  [[nodiscard]] int cycles() const { return cycles_; }
  /// @param state  to answer. @param k  cycles since the motion began, from 1 on; beyond cycles()
  /// the last one.
  [[nodiscard]] RobotCommand At(const RobotState& state, int k) const;
  /// How far the reference is from where the path has it after the k-th command, rad or m, or from
  /// its velocity.
  [[nodiscard]] double Off(const RobotState& state, int k) const;

 private:
  struct Point {
    double way = 0;
    double rate = 0;  ///< per s
  };
  [[nodiscard]] Point PointAt(int k) const;

  const MotionGeneratorMode generator_;
  const JointVector q_0_;
  const Transform O_T_EE_0_;
  const int cycles_;
  const std::size_t joint_;
  double length_ = 0;  ///< L, rad or m, either sign; 0: it stands
};

}  // namespace twin::campaign
