#pragma once

#include "twin/core/joint_interface.h"
#include "twin/core/realtime.h"
#include "twin/plant/base_body.h"
#include "twin/plant/hand_body.h"

namespace twin::plant {

/// The arm's body: torque in, joint motion out, one millisecond at a time.
///
/// Threads: one thread. Real-time: Step() is noexcept and allocates nothing.
class Plant {
 public:
  virtual ~Plant() = default;

  /// Puts the arm at rest at `q` (rad) and restarts plant time and noise. Does not throw.
  virtual void Reset(const JointVector& q) = 0;

  /// Advances by exactly 1 ms under `drive`, held constant over the step; sensors() then tells the
  /// outcome.
  virtual void Step(const JointDrive& drive) noexcept TWIN_REALTIME = 0;

  /// Tells that the robot begins a motion with the next Step(): people who wait for one see the arm
  /// move (plant::Push::motion). Real-time: noexcept.
  virtual void BeginMotion() noexcept TWIN_REALTIME {}

  /// The sensors after the last Step() or Reset().
  [[nodiscard]] virtual const JointSensors& sensors() const noexcept = 0;

  /// The hand on the flange, owned by the plant; null when there is none.
  [[nodiscard]] virtual HandBody* hand() noexcept { return nullptr; }

  /// The mobile base below the arm, owned by the plant; null when the arm stands on the world.
  [[nodiscard]] virtual BaseBody* base() noexcept { return nullptr; }
};

}  // namespace twin::plant
