#pragma once

#include <vector>

#include "twin/core/joint_vector.h"
#include "twin/plant/scene_object.h"

namespace twin::application {

/// How the hand holds an object.
struct Grip {
  Transform B_T_NE = kIdentityTransform;  ///< between the fingertips, in the object's frame
  Vector3 B_up{0, 0, 1};                  ///< where the hand comes from, object's axes
  double width = 0;                       ///< of the object between the fingers, m
};

/// What a hand leaves room for.
struct GripRoom {
  double palm = 0.01;     ///< m, between object and palm
  double below = 0.005;   ///< m, between the fingertips and what the object stands on
  double beside = 0.003;  ///< m, at each finger, when the hand is open
};

/// All grips from above: a box by either pair of its upright faces, a cylinder that stands all
/// around in eighths, one that lies across its axis or by its ends; each both ways round. Gripped
/// is at the middle of the height, higher where the palm would be in the way of that.
/// @param up  normal of what the object stands on, in the world.
/// @returns none of an object too wide, or too flat.
[[nodiscard]] std::vector<Grip> GripsOf(const plant::SceneObject& object, const Vector3& up,
                                        const GripRoom& room);

}  // namespace twin::application
