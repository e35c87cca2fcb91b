#pragma once

#include <array>

// Interface between a base's controller and its body, like joint_interface.h for the arm. Wheels
// are ordered front left, front right, rear left, rear right; positive rotation drives forwards.
namespace twin {

/// Wheel sensors of a base.
struct WheelSensors {
  std::array<double, 4> q{};   ///< rotation since the start, rad, not wrapped
  std::array<double, 4> dq{};  ///< rad/s
};

/// Drive commands of a base for one cycle.
struct WheelDrive {
  std::array<double, 4> tau{};  ///< per wheel, Nm
};

}  // namespace twin
