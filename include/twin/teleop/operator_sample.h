#pragma once

#include <array>
#include <cstdint>

#include "twin/core/joint_vector.h"
#include "twin/core/mobile_base.h"
#include "twin/core/time.h"

namespace twin::teleop {

/// What the axes of a device mean.
enum class AxisKind : std::uint8_t {
  kRate = 0,  ///< deflections, shares of full scale in [-1, 1]: sticks, a SpaceMouse, a page
  kPose = 1,  ///< where the handle is, m and rad from the device's origin: a haptic device
};

/// What the operator's hands do, as a device tells it. Trivially copyable; goes over wires that
/// lose and reorder, so presses are counted, not told: a counter that went on by k was pressed k
/// times. Counters stand at zero as a device's life begins.
struct OperatorSample {
  std::uint64_t sequence = 0;  ///< grows with every sample of a device, from 1
  Time at{};                   ///< on the device's own clock
  AxisKind kind = AxisKind::kRate;
  Vector6 axes{};                     ///< x, y, z, about x, y, z: ahead, left, up of the operator
  bool engaged = true;                ///< clutch: false re-centres the handle without any motion
  std::uint32_t mode_presses = 0;     ///< switches between arm and base
  std::uint32_t gripper_presses = 0;  ///< closes or opens the hand
  std::uint32_t frame_presses = 0;    ///< switches between axes of the base and of the end effector
  std::uint32_t scale_presses = 0;    ///< switches between coarse and fine motion
  std::uint32_t stop_presses = 0;     ///< emergency stop
  std::uint32_t release_presses = 0;  ///< ends an emergency stop
  std::uint32_t end_presses = 0;      ///< ends the session
};

/// How often a button was pressed since its counter stood at `before`. One that fell is of a device
/// whose life began anew: where it stands is the new begin, and nothing was pressed.
[[nodiscard]] constexpr std::uint32_t PressesSince(std::uint32_t before,
                                                   std::uint32_t now) noexcept {
  return now >= before ? now - before : 0;
}

/// What the operator moves.
enum class Mode : std::uint8_t {
  kArm = 0,
  kBase = 1,
};

/// What goes back to a device: what it makes felt, and what a screen shows. Trivially copyable.
struct OperatorFeedback {
  std::uint64_t sequence = 0;  ///< grows with every one, from 1
  std::uint64_t echo = 0;      ///< sequence of the newest sample that had arrived
  Vector6
      wrench{};  ///< at the handle, N and Nm, in the axes of the sample: scaled, filtered, passive
  Mode mode = Mode::kArm;
  bool stopped = false;      ///< emergency stop
  bool holding = false;      ///< the device is lost or its samples are too old
  bool hand_closed = false;  ///< as it was last asked for
  bool fine = false;         ///< motion is scaled down
  bool at_border = false;    ///< the arm goes no further that way: workspace, posture or force
};

}  // namespace twin::teleop
