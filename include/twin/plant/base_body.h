#pragma once

#include <filesystem>

#include "twin/core/base_interface.h"
#include "twin/core/mobile_base.h"
#include "twin/core/realtime.h"

namespace twin::plant {

/// A mobile base under the arm: a URDF that ends in a link named `arm_mount`, where the arm's own
/// base O then stands, and that has four wheels on continuous joints, named front_left_wheel,
/// front_right_wheel, rear_left_wheel and rear_right_wheel, each touching with one cylinder.
///
/// With a base the world's frame lies on the floor (z = 0), and O moves with the base.
struct BaseOptions {
  std::filesystem::path urdf;
  BasePose start;  ///< of the point between the wheels, on the floor
};

/// The base's body: torques on its wheels in, their turning out. It moves with its plant's Step().
///
/// Threads: the plant's. Real-time: noexcept, allocates nothing.
class BaseBody {
 public:
  virtual ~BaseBody() = default;

  /// What the drives do from the next Step() of the plant on, until told otherwise. After
  /// Plant::Reset(): nothing.
  virtual void Drive(const WheelDrive& drive) noexcept TWIN_REALTIME = 0;

  /// The sensors after the last Step() or Reset(). Reset() leaves the base at rest on its tyres, at
  /// its start, all q zero.
  [[nodiscard]] virtual const WheelSensors& sensors() const noexcept = 0;
};

}  // namespace twin::plant
