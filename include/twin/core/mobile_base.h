#pragma once

#include <array>
#include <cstdint>

// What a mobile base is asked for and what it answers. A base is driven by twists in its own plane:
// x ahead, y to the left, z up; it cannot move sideways.
namespace twin {

/// Velocity of a base in its own frame.
struct BaseTwist {
  double v = 0;  ///< ahead, m/s
  double w = 0;  ///< about z, to the left, rad/s
  bool operator==(const BaseTwist&) const = default;
};

/// Where a base is in the plane.
struct BasePose {
  double x = 0;    ///< m
  double y = 0;    ///< m
  double yaw = 0;  ///< rad, not wrapped
  bool operator==(const BasePose&) const = default;
};

/// What a base does, and why.
enum class BaseMode : std::uint8_t {
  kStanding = 0,       ///< no command yet, or the last one is too old: braked to a stand
  kDriving = 1,        ///< follows the last command
  kEmergencyStop = 2,  ///< braked as hard as it can; until it is released
};

/// What a base reports, every millisecond.
struct BaseState {
  std::uint64_t message_id = 0;       ///< cycles (ms) since the base was switched on
  BasePose odometry;                  ///< from the wheels' turns, where it was switched on
  BaseTwist twist;                    ///< from the wheels' speeds
  BaseTwist twist_d;                  ///< commanded, after its limits
  std::array<double, 4> dq_wheels{};  ///< rad/s: front left, front right, rear left, rear right
  BaseMode mode = BaseMode::kStanding;
  bool operator==(const BaseState&) const = default;
};

}  // namespace twin
