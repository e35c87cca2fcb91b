#pragma once

#include "twin/core/limits.h"

namespace twin::test {

/// The Panda's joint limits, for tests that want no file. Source: Franka Control Interface
/// documentation, "Robot and interface specifications", limits for Panda. A test compares them with
/// models/robots/panda/limits.yaml.
inline JointLimits PandaLimits() {
  return {.q_min = {-2.8973, -1.7628, -2.8973, -3.0718, -2.8973, -0.0175, -2.8973},
          .q_max = {2.8973, 1.7628, 2.8973, -0.0698, 2.8973, 3.7525, 2.8973},
          .dq_max = {2.175, 2.175, 2.175, 2.175, 2.61, 2.61, 2.61},
          .ddq_max = {15, 7.5, 10, 12.5, 15, 20, 20},
          .dddq_max = {7500, 3750, 5000, 6250, 7500, 10000, 10000},
          .tau_max = {87, 87, 87, 87, 12, 12, 12},
          .dtau_max = {1000, 1000, 1000, 1000, 1000, 1000, 1000}};
}

/// Its limits of the end effector and the elbow; source and comparison as above.
inline CartesianLimits PandaCartesianLimits() {
  return {.translation = {1.7, 13.0, 6500.0},
          .rotation = {2.5, 25.0, 12500.0},
          .elbow = {2.175, 10.0, 5000.0}};
}

}  // namespace twin::test
