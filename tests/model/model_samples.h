#pragma once

#include <cstdint>

#include "support/panda_limits.h"
#include "twin/core/random.h"
#include "twin/model/mass_properties.h"
#include "twin/model/transform.h"

namespace twin::model {

/// One random state of the arm within its limits, with an acceleration of a few rad/s^2.
struct Sample {
  JointVector q{};
  JointVector dq{};
  JointVector ddq{};
};

/// @returns the same sample for the same index, always.
inline Sample SampleOf(std::uint64_t index) {
  const Random random(2, RandomStream::kTest);
  const JointLimits limits = test::PandaLimits();
  Sample sample;
  for (std::size_t i = 0; i < kJoints; ++i) {
    const auto draw = static_cast<std::uint32_t>(3 * i);
    const double u = random.Uniform(index, draw);
    sample.q[i] = limits.q_min[i] + u * (limits.q_max[i] - limits.q_min[i]);
    sample.dq[i] = (2 * random.Uniform(index, draw + 1) - 1) * limits.dq_max[i];
    sample.ddq[i] = (2 * random.Uniform(index, draw + 2) - 1) * 5;
  }
  return sample;
}

/// The Franka Hand. Source: franka_ros, franka_description.
inline constexpr Payload kHand{0.73, {-0.01, 0, 0.03}, {0.001, 0, 0, 0, 0.0025, 0, 0, 0, 0.0017}};

/// Its nominal end effector: -45 degrees about z, 0.1034 m along z. Source: franka_ros.
inline constexpr double kCos45 = 0.70710678118654752440;
inline constexpr Transform kHandPose{kCos45, -kCos45, 0, 0, kCos45, kCos45, 0,      0,
                                     0,      0,       1, 0, 0,      0,      0.1034, 1};

/// A heavy, lopsided body with products of inertia, and gravity that points nowhere special.
inline constexpr Payload kLump{
    2.5, {0.04, -0.06, 0.11}, {0.02, 0.003, -0.004, 0.003, 0.03, 0.005, -0.004, 0.005, 0.025}};
inline constexpr Vector3 kTilted{1.7, -2.9, -9.1};

/// The configuration most examples start from.
inline constexpr JointVector kReady{0,
                                    -0.78539816339744830962,
                                    0,
                                    -2.35619449019234492885,
                                    0,
                                    1.57079632679489661923,
                                    0.78539816339744830962};

}  // namespace twin::model
