#pragma once

#include "twin/onboard/base_controller.h"
#include "twin/plant/plant.h"

namespace twin::test {

/// The Husky's figures, for tests that do not read models/robots/husky/base.yaml;
/// scenario_base_test holds them against it.
inline onboard::BaseConfig HuskyConfig() {
  return {.wheel_radius = 0.1651,
          .track = 0.5708,
          .track_factor = 1.805,
          .most = {.v = 1, .w = 2},
          .ordinary = {.dv = 0.5, .dw = 1},
          .lost = {.dv = 1, .dw = 2},
          .emergency = {.dv = 3, .dw = 6},
          .tau_max = 35};
}

/// The Husky where a run begins, between its wheels.
inline plant::BaseOptions Husky(const BasePose& start = {}) {
  return {TWIN_SOURCE_DIR "/models/robots/husky/husky.urdf", start};
}

}  // namespace twin::test
