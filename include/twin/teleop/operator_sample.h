#pragma once

#include <array>
#include <cstdint>

#include "twin/core/joint_vector.h"
#include "twin/core/mobile_base.h"
#include "twin/core/time.h"
#include "twin/teleop/twist_bounds.h"

namespace twin::teleop {

/// Meaning of a device's axes.
enum class AxisKind : std::uint8_t {
  kRate = 0,  ///< deflections, shares of full scale in [-1, 1]: sticks, a SpaceMouse, the
              ///< operator's page
  kPose = 1,  ///< pose of the handle, m and rad from the device's origin: a haptic device
};

/// The operator's input, as sent by a device. Trivially copyable. The wire may lose and reorder
/// samples, so presses are transmitted as counters: a counter that rose by k means k presses.
/// Counters start at zero with the device.
struct OperatorSample {
  std::uint64_t sequence = 0;  ///< rises with every sample of a device, from 1
  Time at{};                   ///< on the device's own clock
  AxisKind kind = AxisKind::kRate;
  Vector6 axes{};  ///< x, y, z, about x, y, z: forward, left, up for the operator
  /// 1 to 7: axes[0] of a stick (kRate) turns this joint of the arm alone; 0: axes move the part of
  /// the mode. Not in network messages.
  std::uint8_t joint = 0;
  bool engaged = true;                ///< clutch: false re-centres the handle without motion
  std::uint32_t mode_presses = 0;     ///< switches between arm and base
  std::uint32_t gripper_presses = 0;  ///< closes or opens the hand
  std::uint32_t frame_presses = 0;    ///< switches between axes of the base and of the end effector
  std::uint32_t scale_presses = 0;    ///< switches between coarse and fine motion
  std::uint32_t stop_presses = 0;     ///< emergency stop
  std::uint32_t release_presses = 0;  ///< ends an emergency stop
  std::uint32_t end_presses = 0;      ///< ends the session
};

/// Presses of a button since its counter was `before`. A counter that fell belongs to a restarted
/// device: it is the new start value, and 0 is returned.
[[nodiscard]] constexpr std::uint32_t PressesSince(std::uint32_t before,
                                                   std::uint32_t now) noexcept {
  return now >= before ? now - before : 0;
}

/// The part that the operator moves.
enum class Mode : std::uint8_t {
  kArm = 0,
  kBase = 1,
};

/// Feedback to a device, for force and display. Trivially copyable.
struct OperatorFeedback {
  std::uint64_t sequence = 0;  ///< rises with every message, from 1
  std::uint64_t echo = 0;      ///< sequence of the newest sample that had arrived
  Vector6
      wrench{};  ///< at the handle, N and Nm, in the axes of the sample: scaled, filtered, passive
  Mode mode = Mode::kArm;
  bool stopped = false;         ///< emergency stop
  bool holding = false;         ///< the device is lost or its samples are too old
  bool awaits_release = false;  ///< until the sticks are centred. Not in network messages
  bool hand_closed = false;     ///< as last commanded
  bool fine = false;            ///< motion is scaled down
  std::uint8_t joint = 0;       ///< that turns alone, 1 to 7; 0: none. Not in network messages
  bool at_border = false;       ///< `limit` is set
  ActiveBound limit{};          ///< what limits the arm in this direction; not in network messages
};

}  // namespace twin::teleop
