#pragma once

#include <cstdint>

#include "twin/core/joint_vector.h"

namespace twin {

/// The workstation's answer to one robot state. Fields that the motion does not use are zero.
/// Source: FCI protocol 5, robot command.
struct RobotCommand {
  std::uint64_t message_id = 0;  ///< id of the robot state that it answers
  JointVector q_c{};             ///< joint position generator, rad
  JointVector dq_c{};            ///< joint velocity generator, rad/s
  Transform O_T_EE_c{};          ///< Cartesian pose generator, EE in O
  Vector6 O_dP_EE_c{};           ///< Cartesian velocity generator, base axes, at the EE origin
  Elbow elbow_c{};               ///< Cartesian generators, when valid_elbow
  bool valid_elbow = false;
  bool motion_generation_finished = false;  ///< requests the end of the motion
  JointVector tau_J_d{};  ///< external controller, Nm, without gravity and friction
};

}  // namespace twin
