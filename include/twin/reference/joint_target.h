#pragma once

#include "twin/core/joint_vector.h"

namespace twin::reference {

/// Target of a joint-space source at one instant.
struct JointTarget {
  JointVector q{};    ///< rad
  JointVector dq{};   ///< rad/s
  JointVector ddq{};  ///< rad/s^2
};

}  // namespace twin::reference
