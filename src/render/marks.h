#pragma once

#include <mujoco/mujoco.h>

#include <array>
#include <span>
#include <vector>

#include "twin/core/joint_vector.h"
#include "twin/rt/scene_record.h"

namespace twin::render {

using Colour = std::array<float, 4>;  ///< red, green, blue, opacity, in [0, 1]

/// A small ball. @param p_W  m. @param radius  m.
[[nodiscard]] mjvGeom Ball(const Vector3& p_W, double radius, const Colour& colour);

/// A cylinder between two points.
[[nodiscard]] mjvGeom Rod(const Vector3& from_W, const Vector3& to_W, double radius,
                          const Colour& colour);

/// An arrow with its tip at the point of force. @param newton_m  length per newton, m.
[[nodiscard]] mjvGeom ForceArrow(const rt::PointForce& force, double newton_m,
                                 const Colour& colour);

}  // namespace twin::render
