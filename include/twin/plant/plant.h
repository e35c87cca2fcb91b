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

  /// Sets the arm to `q` (rad) at rest and restarts plant time and noise. Does not throw.
  virtual void Reset(const JointVector& q) = 0;

  /// Advances by exactly 1 ms under `drive`, constant over the step; then sensors() has the result.
  virtual void Step(const JointDrive& drive) noexcept TWIN_REALTIME = 0;

  /// Announces that a motion starts with the next Step(), for plant::Push::motion. Real-time:
  /// noexcept.
  virtual void BeginMotion() noexcept TWIN_REALTIME {}

  /// Sensors after the last Step() or Reset().
  [[nodiscard]] virtual const JointSensors& sensors() const noexcept = 0;

  /// The hand on the flange, owned by the plant; null without one.
  [[nodiscard]] virtual HandBody* hand() noexcept { return nullptr; }

  /// The mobile base below the arm, owned by the plant; null if the arm is fixed to the world.
  [[nodiscard]] virtual BaseBody* base() noexcept { return nullptr; }
};

}  // namespace twin::plant
