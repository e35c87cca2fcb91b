#pragma once

#include <vector>

#include <mujoco/mujoco.h>

namespace twin::planning {

/// Two shapes that may touch, in the order in which the engine's narrow phase wants them.
struct ShapePair {
  int geom1 = -1;
  int geom2 = -1;
  double margin = 0;  ///< m; the model's own: closer than this the engine makes a contact
};

/// Whether the engine would make contacts between two shapes: by their masks, the bodies that carry
/// them, and the pairs of bodies the model excludes. Pairs that a model lists one by one (MJCF
/// <pair>) come on top.
[[nodiscard]] bool CanCollide(const mjModel& model, int geom_a, int geom_b);

[[nodiscard]] ShapePair MakePair(const mjModel& model, int geom_a, int geom_b);

/// A cheap bound: false only when the shapes are further apart than `margin`.
[[nodiscard]] bool MayTouch(const mjModel& model, const mjData& data, int geom1, int geom2,
                            double margin) noexcept;

/// Room for what the narrow phase finds of one pair.
using Contacts = std::vector<mjContact>;  // of size mjMAXCONPAIR

/// @param contacts  room for what is found. @returns how many places closer than `margin` the
/// engine found; they are the first of `contacts`.
[[nodiscard]] int NarrowPhase(const mjModel& model, const mjData& data, const ShapePair& pair,
                              double margin, Contacts& contacts);

}  // namespace twin::planning
