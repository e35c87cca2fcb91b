#pragma once

#include "twin/core/joint_vector.h"

namespace twin::reference {

/// Target of a Cartesian source for the end effector at one instant.
struct PoseTarget {
  Transform O_T_EE = kIdentityTransform;  ///< pose of EE in the base
  Vector6 O_dP_EE{};                      ///< its twist [v; w], base axes, at the EE origin
};

}  // namespace twin::reference
