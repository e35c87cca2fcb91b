#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "twin/core/body_interface.h"
#include "twin/core/joint_vector.h"
#include "twin/core/modes.h"
#include "twin/core/robot_errors.h"

namespace twin {

/// One acceleration per instrumented link: element (link n, axis r) is index 3 n + r.
using Accelerations = std::array<double, 18>;

/// Robot state, every millisecond. Names, units and frames are Franka's. Source: FCI protocol 5,
/// robot state.
///
/// Frames: O base, F flange, NE nominal end effector, EE end effector, K stiffness frame. Suffix
/// _d: desired, after the robot's kinematic completion; _c: last commanded value. All SI and rad;
/// poses are 4 x 4 column-major. A field that the running backend does not estimate stays zero.
struct RobotState {
  std::uint64_t message_id = 0;  ///< milliseconds since robot start, +1 per cycle

  Transform O_T_EE = kIdentityTransform;    ///< measured pose of EE in O
  Transform O_T_EE_d = kIdentityTransform;  ///< desired pose of EE in O
  Transform F_T_EE = kIdentityTransform;    ///< EE in F = F_T_NE NE_T_EE
  Transform EE_T_K = kIdentityTransform;    ///< K in EE
  Transform F_T_NE = kIdentityTransform;    ///< NE in F
  Transform NE_T_EE = kIdentityTransform;   ///< EE in NE

  double m_ee = 0;      ///< end effector: mass
  Matrix3 I_ee{};       ///< inertia about its centre of mass, flange axes
  Vector3 F_x_Cee{};    ///< centre of mass in F
  double m_load = 0;    ///< load: mass
  Matrix3 I_load{};     ///< inertia about its centre of mass, flange axes
  Vector3 F_x_Cload{};  ///< centre of mass in F

  Elbow elbow{};    ///< measured
  Elbow elbow_d{};  ///< desired

  JointVector tau_J{};    ///< measured link-side torque, gravity included
  JointVector tau_J_d{};  ///< desired torque without gravity and friction
  JointVector dtau_J{};   ///< derivative of tau_J, Nm/s
  JointVector q{};        ///< measured position
  JointVector q_d{};      ///< desired position
  JointVector dq{};       ///< measured velocity
  JointVector dq_d{};     ///< desired velocity
  JointVector ddq_d{};    ///< desired acceleration

  JointVector joint_contact{};
  Vector6 cartesian_contact{};
  JointVector joint_collision{};
  Vector6 cartesian_collision{};
  JointVector tau_ext_hat_filtered{};  ///< filtered external joint torque
  Vector6 O_F_ext_hat_K{};  ///< external wrench at K, base axes; positive: robot pushes on its
                            ///< environment
  Vector6 K_F_ext_hat_K{};  ///< the same in K axes

  Vector6 O_dP_EE_d{};           ///< desired twist of EE, base axes
  Vector3 O_ddP_O{0, 0, -9.81};  ///< gravity in O
  Elbow elbow_c{};
  Elbow delbow_c{};
  Elbow ddelbow_c{};
  Transform O_T_EE_c = kIdentityTransform;
  Vector6 O_dP_EE_c{};
  Vector6 O_ddP_EE_c{};

  JointVector theta{};   ///< motor position
  JointVector dtheta{};  ///< motor velocity

  /// Of an FR3 (FCI protocol 10): proper acceleration of the links 0 to 5 at two places each, in
  /// the sensor's axes, m/s^2.
  Accelerations accelerometer_top{};
  Accelerations accelerometer_bottom{};

  MotionGeneratorMode motion_generator_mode = MotionGeneratorMode::kIdle;
  ControllerMode controller_mode = ControllerMode::kOther;
  RobotErrors errors;         ///< current errors
  RobotErrors reflex_reason;  ///< errors that ended the previous motion
  RobotMode robot_mode = RobotMode::kOther;
  double control_command_success_rate =
      0;  ///< share of the last 100 commands received; 0 when no motion runs
};

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

/// Whether all values are finite.
///
/// Threads: any. Real-time: noexcept, allocates nothing; so are the overloads.
template <std::size_t N>
[[nodiscard]] bool IsFinite(const std::array<double, N>& values) noexcept {
  // Without a branch per value, which saves a third of the time: infinity and NaN have an exponent
  // of ones alone, and adding one to it carries into the sign.
  constexpr std::uint64_t kExponent = 0x7ff0'0000'0000'0000;
  constexpr std::uint64_t kOne = 0x0010'0000'0000'0000;
  std::uint64_t carries = 0;
  for (const double x : values) carries |= (std::bit_cast<std::uint64_t>(x) & kExponent) + kOne;
  return carries >> 63 == 0;
}

[[nodiscard]] bool IsFinite(const JointSensors& sensors) noexcept;
[[nodiscard]] bool IsFinite(const RobotState& state) noexcept;

}  // namespace twin
