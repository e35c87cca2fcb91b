#pragma once

#include "twin/core/limits.h"

namespace twin::test {

/// The Franka Research 3's joint limits, for tests that want no file. Sources:
/// models/robots/fr3/robot.yaml; a test compares them with models/robots/fr3/limits.yaml.
inline JointLimits Fr3Limits() {
  return {.q_min = {-2.7501, -1.7918, -2.9065, -3.0481, -2.8101, 0.54092, -3.0196},
          .q_max = {2.7501, 1.7918, 2.9065, -0.1458, 2.8101, 4.5205, 3.0196},
          .dq_max = {2.62, 2.62, 2.62, 2.62, 5.26, 4.18, 5.26},
          .ddq_max = {10, 10, 10, 10, 10, 10, 10},
          .dddq_max = {5000, 5000, 5000, 5000, 5000, 5000, 5000},
          .tau_max = {87, 87, 87, 87, 12, 12, 12},
          .dtau_max = {1000, 1000, 1000, 1000, 1000, 1000, 1000},
          .velocity_offset = {0.3, 0.2, 0.2, 0.3, 0.35, 0.35, 0.35},
          .deceleration = {6, 2.585, 3.5, 4, 17, 5.5, 17}};
}

}  // namespace twin::test
