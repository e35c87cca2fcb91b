#include "twin/onboard/int_config.h"

#include <fmt/format.h>

#include "twin/core/require.h"

namespace twin::onboard {

void IntConfig::Validate() const {
  limits.Validate();
  for (std::size_t i = 0; i < kJoints; ++i) {
    RequireInRange(fmt::format("int: K_theta[{}]", i), K_theta[i], 0, kMaxJointStiffness);
    RequireInRange(fmt::format("int: rotor_inertia[{}]", i), rotor_inertia[i], 0, 10);
    if (tau_J_range) {
      RequireInRange(fmt::format("int: tau_J_range[{}]", i), (*tau_J_range)[i], 1e-6, 1000);
    }
  }
  RequireInRange("int: damping_ratio", damping_ratio, 1e-6, 2);
  RequireInRange("int: friction_compensation", friction_compensation, 0, 1);
  RequireInRange("int: end_effector.m", end_effector.m, 0, 100);
  RequireInRange("int: abort_after_lost", abort_after_lost, 1, 1e6);
  RequireInRange("int: first_command_timeout_cycles", first_command_timeout_cycles, 10, 1e6);
  RequireInRange("int: start_pose_tolerance_rad", start_pose_tolerance_rad, 1e-6, 7);
}

}  // namespace twin::onboard
