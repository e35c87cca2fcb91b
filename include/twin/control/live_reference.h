#pragma once

#include "twin/core/joint_vector.h"
#include "twin/core/realtime.h"
#include "twin/core/robot_state.h"
#include "twin/core/time.h"
#include "twin/reference/pose_target.h"

namespace twin::control {

/// What a controller of poses follows when nobody knows the way beforehand: a person at a device.
///
/// Life: Begin once per motion, then Next once per update of the controller. Continuous: of two
/// calls one period apart, the poses differ by what the promised twist, acceleration and jerk
/// allow.
///
/// Threads: Begin and Next from the controller's thread. Real-time: Next() is noexcept, allocates
/// nothing, waits for nobody.
class LiveReference {
 public:
  virtual ~LiveReference() = default;

  /// The motion begins: the reference is at rest at `O_T_EE`, where the end effector is.
  virtual void Begin(const Transform& O_T_EE, Time now) = 0;

  /// The pose to be followed now, and its twist, in the base's axes.
  [[nodiscard]] virtual reference::PoseTarget Next(const RobotState& state,
                                                   Time now) noexcept TWIN_REALTIME = 0;

  /// Whether the one who leads has ended the motion, and the reference rests.
  [[nodiscard]] virtual bool finished() const noexcept TWIN_REALTIME = 0;
};

}  // namespace twin::control
