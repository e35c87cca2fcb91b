#include "twin/onboard/int_config.h"

#include <cmath>

#include <fmt/format.h>

#include "twin/core/error.h"

namespace twin::onboard {
namespace {

void RequireInRange(const char* field, double value, double low, double high) {
  if (value >= low && value <= high) return;
  throw InputError(fmt::format("int: {} is {}; it must lie in [{}, {}]", field, value, low, high));
}

}  // namespace

void IntConfig::Validate() const {
  limits.Validate();
  for (std::size_t i = 0; i < kJoints; ++i) {
    RequireInRange(fmt::format("K_theta[{}]", i).c_str(), K_theta[i], 0, 14250);
    RequireInRange(fmt::format("rotor_inertia[{}]", i).c_str(), rotor_inertia[i], 0, 10);
  }
  RequireInRange("damping_ratio", damping_ratio, 1e-6, 2);
  RequireInRange("end_effector.m", end_effector.m, 0, 100);
  RequireInRange("abort_after_lost", abort_after_lost, 1, 1000);
  RequireInRange("first_command_timeout_cycles", first_command_timeout_cycles, 10, 1e6);
  RequireInRange("start_pose_tolerance_rad", start_pose_tolerance_rad, 1e-6, 7);
}

}  // namespace twin::onboard
