#pragma once

#include <array>
#include <cstdint>

// Commands to a mobile base and its state. A base is commanded by twists in its own plane: x
// forwards, y to the left, z up; it cannot move sideways.
namespace twin {

/// Velocity of a base in its own frame.
struct BaseTwist {
  double v = 0;  ///< forwards, m/s
  double w = 0;  ///< about z, to the left, rad/s
  bool operator==(const BaseTwist&) const = default;
};

/// Pose of a base in the plane.
struct BasePose {
  double x = 0;    ///< m
  double y = 0;    ///< m
  double yaw = 0;  ///< rad, not wrapped
  bool operator==(const BasePose&) const = default;
};

/// What a base does and why.
enum class BaseMode : std::uint8_t {
  kStanding = 0,       ///< no valid command: braked to rest
  kDriving = 1,        ///< follows the last command
  kEmergencyStop = 2,  ///< full braking until release
};

/// State of a base, every millisecond.
struct BaseState {
  std::uint64_t message_id = 0;       ///< cycles (ms) since the base was switched on
  BasePose odometry;                  ///< from wheel rotations, relative to power-on
  BaseTwist twist;                    ///< from wheel speeds
  BaseTwist twist_d;                  ///< commanded, after limits
  std::array<double, 4> dq_wheels{};  ///< rad/s: front left, front right, rear left, rear right
  BaseMode mode = BaseMode::kStanding;
  bool operator==(const BaseState&) const = default;
};

}  // namespace twin
