#include "twin/onboard/onboard_config.h"

#include <fmt/format.h>

#include "twin/core/error.h"
#include "twin/core/setting.h"
#include "twin/model/transform.h"
#include "twin/onboard/arm_setup.h"

namespace twin::onboard {
namespace {

void RequireValid(const Setting& setting) {
  const std::optional<BadValue> bad = FindBadValue(setting);
  if (bad) throw InputError(fmt::format("onboard: {}", Describe(*bad)));
}

}  // namespace

void OnboardConfig::Validate() const {
  limits.Validate();
  cartesian.Validate();
  if (own_limits) own_limits->Validate();
  sensing.Validate();
  guard.Validate();
  for (const Setting& setting :
       {Setting(joint_impedance), Setting(cartesian_impedance), Setting(collision_behavior),
        Setting(guiding_mode), Setting(stiffness_frame), Setting(end_effector_frame), Setting(load),
        Setting(filters)}) {
    RequireValid(setting);
  }
  for (std::size_t i = 0; i < kJoints; ++i) {
    RequireInRange(fmt::format("onboard: rotor_inertia[{}]", i), rotor_inertia[i], 0, 10);
  }
  if (!IsRigid(F_T_NE))
    throw InputError("onboard: F_T_NE is not allowed; it must be a rigid transform");
  RequireInRange("onboard: damping_ratio", damping_ratio, 1e-6, 2);
  RequireInRange("onboard: friction_compensation", friction_compensation, 0, 1);
  RequireInRange("onboard: end_effector.m", end_effector.m, 0, 100);
  if (!IsInertiaOfBody(end_effector.I)) {
    throw InputError(
        "onboard: end_effector.I is not that of a body; it must be symmetric, with no principal "
        "moment "
        "negative or above the other two together");
  }
  RequireInRange("onboard: abort_after_lost", abort_after_lost, 1, 1e6);
  RequireInRange("onboard: first_command_timeout_cycles", first_command_timeout_cycles, 10, 1e6);
  RequireInRange("onboard: start_pose_tolerance_rad", start_pose_tolerance_rad, 1e-6, 7);
  RequireInRange("onboard: start_translation_tolerance_m", start_translation_tolerance_m, 1e-6, 10);
  RequireInRange("onboard: start_rotation_tolerance_rad", start_rotation_tolerance_rad, 1e-6, 7);
  RequireInRange("onboard: start_elbow_tolerance_rad", start_elbow_tolerance_rad, 1e-6, 7);
}

ArmSetup SetupOf(const OnboardConfig& config) noexcept {
  const setting::Load& load = config.load;
  return {.F_T_EE = model::Multiply(config.F_T_NE, config.end_effector_frame.NE_T_EE),
          .EE_T_K = config.stiffness_frame.EE_T_K,
          .payload = model::Combine(config.end_effector,
                                    {.m = load.m_load, .F_x_C = load.F_x_Cload, .I = load.I_load})};
}

}  // namespace twin::onboard
