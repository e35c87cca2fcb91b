#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "twin/core/joint_vector.h"
#include "twin/core/limits.h"
#include "twin/model/arm_model.h"
#include "twin/onboard/base_controller.h"
#include "twin/plant/mujoco_plant.h"
#include "twin/scenario/objects.h"

namespace twin::scenario {

/// Data of a robot, read from its folder below models/robots.
struct RobotData {
  std::string name;                                ///< "panda"
  std::filesystem::path urdf;                      ///< <name>/<name>.urdf
  std::uint16_t protocol = 5;                      ///< of the Franka Control Interface
  model::ArmModel arm = model::ArmModel::Panda();  ///< by which INT reckons
  JointLimits limits;                              ///< from <name>/limits.yaml
  CartesianLimits cartesian;                       ///< from the same
  JointVector rotor_inertia{};  ///< from <name>/drives.yaml; seen at the link, kg m^2
  model::Payload end_effector;  ///< of the mounted hand, flange axes; all zero without one
  Transform F_T_NE = kIdentityTransform;  ///< nominal end effector in the flange frame

  /// @param NE_T_EE  as the robot is told. @returns the end effector in the flange.
  [[nodiscard]] Transform F_T_EE(const FramePose& NE_T_EE) const;
};

/// Reads the joint limits of a limits.yaml:
///   joints:
///     q_min: {unit: rad, values: [7 numbers]}   # and q_max, dq_max, ddq_max, dddq_max, tau_max,
///                                               # dtau_max; velocity_offset, deceleration if the
///                                               # velocity limit depends on the position
/// @throws InputError naming file, line and key.
[[nodiscard]] JointLimits LoadJointLimits(const std::filesystem::path& file);

/// Reads the limits of the end effector's motion and of the elbow angle from the same file:
///   cartesian:
///     translation:                          # m/s, m/s^2, m/s^3; rotation and elbow: rad/s, ...
///       dp_max: {unit: m/s, value: 1.7}     # and ddp_max, dddp_max
/// @throws InputError naming file, line and key.
[[nodiscard]] CartesianLimits LoadCartesianLimits(const std::filesystem::path& file);

/// @param models  the models folder. @param name  folder below models/robots.
/// @throws InputError for an unknown robot (lists the known ones), and for invalid data (names
/// file, line and key).
[[nodiscard]] RobotData LoadRobotData(const std::filesystem::path& models, std::string_view name,
                                      plant::HandKind hand);

/// Data of a mobile base, read from its folder below models/robots.
struct BaseData {
  std::filesystem::path urdf;  ///< <name>/<name>.urdf
  onboard::BaseConfig config;  ///< from <name>/base.yaml
};

/// @param models  the models folder. @param name  folder below models/robots.
/// @throws InputError for an unknown base (lists the known ones), and for invalid data (names file,
/// line and key).
[[nodiscard]] BaseData LoadBaseData(const std::filesystem::path& models, std::string_view name);

}  // namespace twin::scenario
