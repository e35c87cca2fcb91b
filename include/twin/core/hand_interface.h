#pragma once

// Between the hand's controller and the hand's body, as joint_interface.h is for the arm.
namespace twin {

/// What the hand's drive senses.
struct HandSensors {
  double width = 0;   ///< distance between the fingers, m
  double dwidth = 0;  ///< its rate, m/s
  /// What each finger presses with, N, as far as the drive can tell: its force less what moves
  /// its own inertia and overcomes its own friction. Positive: outwards, so negative while an
  /// object is held between the fingers.
  double force = 0;
};

/// What the hand's controller asks of the drive for one cycle. A dynamic hand acts on force; the
/// ideal hand, which has no dynamics, follows the desired motion.
struct HandDrive {
  double force = 0;    ///< on each finger, N; positive opens
  double width_d = 0;  ///< m
};

}  // namespace twin
