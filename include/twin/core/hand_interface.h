#pragma once

// Interface between the hand's controller and its body, like joint_interface.h for the arm.
namespace twin {

/// Sensors of the hand's drive.
struct HandSensors {
  double width = 0;   ///< distance between the fingers, m
  double dwidth = 0;  ///< its rate, m/s
  /// Force of each finger, N, estimated by the drive: its force less its own inertia and friction.
  /// Positive: outwards, so negative while the fingers hold an object between them.
  double force = 0;
};

/// Drive commands of the hand for one cycle. A dynamic hand applies force; the ideal hand, which
/// has no dynamics, follows the desired motion.
struct HandDrive {
  double force = 0;    ///< on each finger, N; positive opens
  double width_d = 0;  ///< m
};

}  // namespace twin
