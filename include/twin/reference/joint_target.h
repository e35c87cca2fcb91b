#pragma once

#include "twin/core/joint_vector.h"

namespace twin::reference {

/// What a joint-space source wants at one instant.
struct JointTarget {
  JointVector q{};    ///< rad
  JointVector dq{};   ///< rad/s
  JointVector ddq{};  ///< rad/s^2
};

}  // namespace twin::reference
