#pragma once

#include <optional>

#include "twin/core/joint_vector.h"
#include "twin/core/realtime.h"
#include "twin/core/robot_state.h"
#include "twin/core/time.h"
#include "twin/reference/target.h"

namespace twin::control {

/// A pose reference that is not known in advance, such as an operator's.
///
/// Life: Begin once per motion, then Next once per update of the controller. The reference is
/// continuous: successive poses differ by at most what the promised twist, acceleration and jerk
/// allow.
///
/// Threads: Begin and Next from the controller's thread. Real-time: Next() is noexcept, does not
/// allocate, never waits.
class LiveReference {
 public:
  virtual ~LiveReference() = default;

  /// Starts the reference at rest at the end effector's pose `O_T_EE`.
  virtual void Begin(const Transform& O_T_EE, Time now) = 0;

  /// The pose to follow now, and its twist in the base's axes.
  [[nodiscard]] virtual reference::PoseTarget Next(const RobotState& state,
                                                   Time now) noexcept TWIN_REALTIME = 0;

  /// The joint positions and velocities that belong to the last pose, for controllers that leave
  /// the arm's redundancy to the reference; absent: it has none.
  [[nodiscard]] virtual std::optional<reference::JointTarget> posture() const noexcept
      TWIN_REALTIME {
    return std::nullopt;
  }

  /// True once the operator has ended the motion and the reference is at rest.
  [[nodiscard]] virtual bool finished() const noexcept TWIN_REALTIME = 0;
};

}  // namespace twin::control
