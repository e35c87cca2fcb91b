#pragma once

#include <filesystem>

#include "twin/core/base_interface.h"
#include "twin/core/mobile_base.h"
#include "twin/core/realtime.h"

namespace twin::plant {

/// A mobile base under the arm: a URDF with a link named `arm_mount`, the pose of the arm's base O,
/// and four wheels on continuous joints, named front_left_wheel, front_right_wheel, rear_left_wheel
/// and rear_right_wheel, each with one cylinder for contact.
///
/// With a base the world frame is on the floor (z = 0), and O moves with the base.
struct BaseOptions {
  std::filesystem::path urdf;
  BasePose start;  ///< of the point between the wheels, on the floor
};

/// The base's body: wheel torques in, wheel rotation out. It advances in its plant's Step().
///
/// Threads: the plant's. Real-time: noexcept, allocates nothing.
class BaseBody {
 public:
  virtual ~BaseBody() = default;

  /// Sets the wheel torques from the plant's next Step() on, until the next call. Plant::Reset()
  /// sets zero.
  virtual void Drive(const WheelDrive& drive) noexcept TWIN_REALTIME = 0;

  /// Sensors after the last Step() or Reset(). Reset() leaves the base at rest on its tyres, at its
  /// start, all q zero.
  [[nodiscard]] virtual const WheelSensors& sensors() const noexcept = 0;
};

}  // namespace twin::plant
