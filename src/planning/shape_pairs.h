#pragma once

#include <vector>

#include <mujoco/mujoco.h>

namespace twin::planning {

/// Two shapes that may touch, in the order required by the engine's narrow phase.
struct ShapePair {
  int geom1 = -1;
  int geom2 = -1;
  double margin = 0;  ///< m; the model's own: the engine makes a contact at smaller distances
};

/// True if the engine would make contacts between two shapes, by their masks, their bodies and the
/// model's excluded pairs of bodies. Pairs listed explicitly (MJCF <pair>) are additional.
[[nodiscard]] bool CanCollide(const mjModel& model, int geom_a, int geom_b);

[[nodiscard]] ShapePair MakePair(const mjModel& model, int geom_a, int geom_b);

/// A cheap bound: false only if the shapes are farther apart than `margin`.
[[nodiscard]] bool MayTouch(const mjModel& model, const mjData& data, int geom1, int geom2,
                            double margin) noexcept;

/// Buffer for the narrow phase of one pair.
using Contacts = std::vector<mjContact>;  // of size mjMAXCONPAIR

/// @param contacts  buffer. @returns the number of points closer than `margin`, stored first in
/// `contacts`.
[[nodiscard]] int NarrowPhase(const mjModel& model, const mjData& data, const ShapePair& pair,
                              double margin, Contacts& contacts);

}  // namespace twin::planning
