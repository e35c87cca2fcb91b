#pragma once

#include <array>

// Between a base's controller and its body, as joint_interface.h is for the arm. Wheels in the
// order front left, front right, rear left, rear right; a wheel that turns positively rolls ahead.
namespace twin {

/// What a base's wheels sense.
struct WheelSensors {
  std::array<double, 4> q{};   ///< turned since the start, rad, not wrapped
  std::array<double, 4> dq{};  ///< rad/s
};

/// What a base's controller asks of its drives for one cycle.
struct WheelDrive {
  std::array<double, 4> tau{};  ///< on each wheel, Nm
};

}  // namespace twin
