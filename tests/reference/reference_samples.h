#pragma once

#include "support/panda_limits.h"
#include "support/pose_samples.h"
#include "twin/core/joint_vector.h"
#include "twin/core/limits.h"
#include "twin/reference/rate_limiter.h"

namespace twin::reference {

inline ClientLimits PandaClientLimits() {
  return ClientLimits::Of(test::PandaLimits(), test::PandaCartesianLimits());
}

using test::Obliqueness;
using test::PoseOf;
using test::PositionOf;
using test::RandomPose;
using test::RandomVector;
using test::RotationOf;
using test::RotationVector;

inline JointVector Filled(double value) {
  JointVector v;
  v.fill(value);
  return v;
}

}  // namespace twin::reference
