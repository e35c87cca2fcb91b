#pragma once

#include "twin/core/joint_vector.h"

namespace twin::scenario {

/// A frame in another one.
struct FramePose {
  Vector3 position{};  ///< m
  Vector3 rpy{};       ///< roll, pitch, yaw about the fixed axes x, y, z, rad: R = Rz Ry Rx

  [[nodiscard]] Transform Matrix() const noexcept;
  bool operator==(const FramePose&) const = default;
};

}  // namespace twin::scenario
