#pragma once

#include <cstddef>
#include <string_view>
#include <tuple>

#include "fci/wire.h"
#include "twin/core/hand_command.h"
#include "twin/core/robot_state.h"
#include "twin/fci/protocol.h"

// Position of each field in its datagram. A field has its member's type and count. The compiler
// checks below that the offsets leave no gap and add up to the datagram's size. Source: FCI
// protocol 5, robot state, robot command, gripper state.
namespace twin::fci {

/// One field of a datagram.
template <typename Struct, typename Value>
struct DatagramField {
  using Type = Value;

  std::string_view name;  ///< Franka's name
  Value Struct::*member;
  std::size_t offset;  ///< bytes
};
template <typename Struct, typename Value>
DatagramField(std::string_view, Value Struct::*, std::size_t) -> DatagramField<Struct, Value>;

inline constexpr std::tuple kStateFields{
    DatagramField{"message_id", &RobotState::message_id, 0},
    DatagramField{"O_T_EE", &RobotState::O_T_EE, 8},
    DatagramField{"O_T_EE_d", &RobotState::O_T_EE_d, 136},
    DatagramField{"F_T_EE", &RobotState::F_T_EE, 264},
    DatagramField{"EE_T_K", &RobotState::EE_T_K, 392},
    DatagramField{"F_T_NE", &RobotState::F_T_NE, 520},
    DatagramField{"NE_T_EE", &RobotState::NE_T_EE, 648},
    DatagramField{"m_ee", &RobotState::m_ee, 776},
    DatagramField{"I_ee", &RobotState::I_ee, 784},
    DatagramField{"F_x_Cee", &RobotState::F_x_Cee, 856},
    DatagramField{"m_load", &RobotState::m_load, 880},
    DatagramField{"I_load", &RobotState::I_load, 888},
    DatagramField{"F_x_Cload", &RobotState::F_x_Cload, 960},
    DatagramField{"elbow", &RobotState::elbow, 984},
    DatagramField{"elbow_d", &RobotState::elbow_d, 1000},
    DatagramField{"tau_J", &RobotState::tau_J, 1016},
    DatagramField{"tau_J_d", &RobotState::tau_J_d, 1072},
    DatagramField{"dtau_J", &RobotState::dtau_J, 1128},
    DatagramField{"q", &RobotState::q, 1184},
    DatagramField{"q_d", &RobotState::q_d, 1240},
    DatagramField{"dq", &RobotState::dq, 1296},
    DatagramField{"dq_d", &RobotState::dq_d, 1352},
    DatagramField{"ddq_d", &RobotState::ddq_d, 1408},
    DatagramField{"joint_contact", &RobotState::joint_contact, 1464},
    DatagramField{"cartesian_contact", &RobotState::cartesian_contact, 1520},
    DatagramField{"joint_collision", &RobotState::joint_collision, 1568},
    DatagramField{"cartesian_collision", &RobotState::cartesian_collision, 1624},
    DatagramField{"tau_ext_hat_filtered", &RobotState::tau_ext_hat_filtered, 1672},
    DatagramField{"O_F_ext_hat_K", &RobotState::O_F_ext_hat_K, 1728},
    DatagramField{"K_F_ext_hat_K", &RobotState::K_F_ext_hat_K, 1776},
    DatagramField{"O_dP_EE_d", &RobotState::O_dP_EE_d, 1824},
    DatagramField{"O_ddP_O", &RobotState::O_ddP_O, 1872},
    DatagramField{"elbow_c", &RobotState::elbow_c, 1896},
    DatagramField{"delbow_c", &RobotState::delbow_c, 1912},
    DatagramField{"ddelbow_c", &RobotState::ddelbow_c, 1928},
    DatagramField{"O_T_EE_c", &RobotState::O_T_EE_c, 1944},
    DatagramField{"O_dP_EE_c", &RobotState::O_dP_EE_c, 2072},
    DatagramField{"O_ddP_EE_c", &RobotState::O_ddP_EE_c, 2120},
    DatagramField{"theta", &RobotState::theta, 2168},
    DatagramField{"dtheta", &RobotState::dtheta, 2224},
    DatagramField{"motion_generator_mode", &RobotState::motion_generator_mode, 2280},
    DatagramField{"controller_mode", &RobotState::controller_mode, 2281},
    DatagramField{"errors", &RobotState::errors, 2282},
    DatagramField{"reflex_reason", &RobotState::reflex_reason, 2323},
    DatagramField{"robot_mode", &RobotState::robot_mode, 2364},
    DatagramField{"control_command_success_rate", &RobotState::control_command_success_rate, 2365},
};

inline constexpr std::tuple kCommandFields{
    DatagramField{"message_id", &RobotCommand::message_id, 0},
    DatagramField{"q_c", &RobotCommand::q_c, 8},
    DatagramField{"dq_c", &RobotCommand::dq_c, 64},
    DatagramField{"O_T_EE_c", &RobotCommand::O_T_EE_c, 120},
    DatagramField{"O_dP_EE_c", &RobotCommand::O_dP_EE_c, 248},
    DatagramField{"elbow_c", &RobotCommand::elbow_c, 296},
    DatagramField{"valid_elbow", &RobotCommand::valid_elbow, 312},
    DatagramField{"motion_generation_finished", &RobotCommand::motion_generation_finished, 313},
    DatagramField{"tau_J_d", &RobotCommand::tau_J_d, 314},
};

inline constexpr std::tuple kHandStateFields{
    DatagramField{"message_id", &HandState::message_id, 0},
    DatagramField{"width", &HandState::width, 4},
    DatagramField{"max_width", &HandState::max_width, 12},
    DatagramField{"is_grasped", &HandState::is_grasped, 20},
    DatagramField{"temperature", &HandState::temperature, 21},
};

/// True if each field begins where the previous one ends, and the last ends at `total`.
template <typename Fields>
[[nodiscard]] constexpr bool IsGapless(const Fields& fields, std::size_t total) {
  std::size_t end = 0;
  const auto follows = [&end](const auto& field) {
    const bool does = field.offset == end;
    end += wire::kBytes<typename std::remove_cvref_t<decltype(field)>::Type>;
    return does;
  };
  return std::apply([&](const auto&... field) { return (follows(field) && ...); }, fields) &&
         end == total;
}

static_assert(IsGapless(kStateFields, kStateBytes));
static_assert(IsGapless(kCommandFields, kCommandBytes));
static_assert(IsGapless(kHandStateFields, kHandStateBytes));

}  // namespace twin::fci
