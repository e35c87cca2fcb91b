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
// protocol 5, robot state, robot command, gripper state, vacuum gripper state. In protocol 10 a
// robot state has the same fields in the same order, in single precision, and the accelerometers; a
// command has those of protocol 5, and torque_command_finished behind them.
namespace twin::fci {

/// One field of a datagram.
template <typename Struct, typename Value>
struct DatagramField {
  using Type = Value;

  std::string_view name;  ///< Franka's name
  Value Struct::*member;
  std::size_t offset;             ///< bytes
  std::size_t offset10 = offset;  ///< in protocol 10

  [[nodiscard]] constexpr std::size_t OffsetIn(Protocol protocol) const noexcept {
    return protocol == Protocol::k5 ? offset : offset10;
  }
};
template <typename Struct, typename Value>
DatagramField(std::string_view, Value Struct::*, std::size_t) -> DatagramField<Struct, Value>;
template <typename Struct, typename Value>
DatagramField(std::string_view, Value Struct::*, std::size_t, std::size_t)
    -> DatagramField<Struct, Value>;

/// Offset of a field that a protocol lacks.
inline constexpr auto kAbsent = static_cast<std::size_t>(-1);

inline constexpr std::tuple kStateFields{
    DatagramField{"message_id", &RobotState::message_id, 0, 0},
    DatagramField{"O_T_EE", &RobotState::O_T_EE, 8, 8},
    DatagramField{"O_T_EE_d", &RobotState::O_T_EE_d, 136, 72},
    DatagramField{"F_T_EE", &RobotState::F_T_EE, 264, 136},
    DatagramField{"EE_T_K", &RobotState::EE_T_K, 392, 200},
    DatagramField{"F_T_NE", &RobotState::F_T_NE, 520, 264},
    DatagramField{"NE_T_EE", &RobotState::NE_T_EE, 648, 328},
    DatagramField{"m_ee", &RobotState::m_ee, 776, 392},
    DatagramField{"I_ee", &RobotState::I_ee, 784, 396},
    DatagramField{"F_x_Cee", &RobotState::F_x_Cee, 856, 432},
    DatagramField{"m_load", &RobotState::m_load, 880, 444},
    DatagramField{"I_load", &RobotState::I_load, 888, 448},
    DatagramField{"F_x_Cload", &RobotState::F_x_Cload, 960, 484},
    DatagramField{"elbow", &RobotState::elbow, 984, 496},
    DatagramField{"elbow_d", &RobotState::elbow_d, 1000, 504},
    DatagramField{"tau_J", &RobotState::tau_J, 1016, 512},
    DatagramField{"tau_J_d", &RobotState::tau_J_d, 1072, 540},
    DatagramField{"dtau_J", &RobotState::dtau_J, 1128, 568},
    DatagramField{"q", &RobotState::q, 1184, 596},
    DatagramField{"q_d", &RobotState::q_d, 1240, 624},
    DatagramField{"dq", &RobotState::dq, 1296, 652},
    DatagramField{"dq_d", &RobotState::dq_d, 1352, 680},
    DatagramField{"ddq_d", &RobotState::ddq_d, 1408, 708},
    DatagramField{"joint_contact", &RobotState::joint_contact, 1464, 736},
    DatagramField{"cartesian_contact", &RobotState::cartesian_contact, 1520, 764},
    DatagramField{"joint_collision", &RobotState::joint_collision, 1568, 788},
    DatagramField{"cartesian_collision", &RobotState::cartesian_collision, 1624, 816},
    DatagramField{"tau_ext_hat_filtered", &RobotState::tau_ext_hat_filtered, 1672, 840},
    DatagramField{"O_F_ext_hat_K", &RobotState::O_F_ext_hat_K, 1728, 868},
    DatagramField{"K_F_ext_hat_K", &RobotState::K_F_ext_hat_K, 1776, 892},
    DatagramField{"O_dP_EE_d", &RobotState::O_dP_EE_d, 1824, 916},
    DatagramField{"O_ddP_O", &RobotState::O_ddP_O, 1872, 940},
    DatagramField{"elbow_c", &RobotState::elbow_c, 1896, 952},
    DatagramField{"delbow_c", &RobotState::delbow_c, 1912, 960},
    DatagramField{"ddelbow_c", &RobotState::ddelbow_c, 1928, 968},
    DatagramField{"O_T_EE_c", &RobotState::O_T_EE_c, 1944, 976},
    DatagramField{"O_dP_EE_c", &RobotState::O_dP_EE_c, 2072, 1040},
    DatagramField{"O_ddP_EE_c", &RobotState::O_ddP_EE_c, 2120, 1064},
    DatagramField{"theta", &RobotState::theta, 2168, 1088},
    DatagramField{"dtheta", &RobotState::dtheta, 2224, 1116},
    DatagramField{"accelerometer_top", &RobotState::accelerometer_top, kAbsent, 1144},
    DatagramField{"accelerometer_bottom", &RobotState::accelerometer_bottom, kAbsent, 1216},
    DatagramField{"motion_generator_mode", &RobotState::motion_generator_mode, 2280, 1288},
    DatagramField{"controller_mode", &RobotState::controller_mode, 2281, 1289},
    DatagramField{"errors", &RobotState::errors, 2282, 1290},
    DatagramField{"reflex_reason", &RobotState::reflex_reason, 2323, 1331},
    DatagramField{"robot_mode", &RobotState::robot_mode, 2364, 1372},
    DatagramField{"control_command_success_rate", &RobotState::control_command_success_rate, 2365,
                  1373},
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

inline constexpr std::tuple kVacuumStateFields{
    DatagramField{"message_id", &VacuumState::message_id, 0},
    DatagramField{"in_control_range", &VacuumState::in_control_range, 4},
    DatagramField{"part_detached", &VacuumState::part_detached, 5},
    DatagramField{"part_present", &VacuumState::part_present, 6},
    DatagramField{"device_status", &VacuumState::device_status, 7},
    DatagramField{"actual_power", &VacuumState::actual_power, 8},
    DatagramField{"vacuum", &VacuumState::vacuum, 12},
};

/// Bytes of a Value in a robot state.
template <Protocol kProtocol, typename Value>
inline constexpr std::size_t kStateFieldBytes =
    kProtocol == Protocol::k10&& wire::kIsReal<Value> ? wire::kBytes<Value> / 2
                                                      : wire::kBytes<Value>;

/// True if each field that the protocol has begins where the previous one ends, and the last ends
/// at `total`. @param bytes_of  of a field.
template <typename Fields, typename BytesOf>
[[nodiscard]] constexpr bool IsGapless(const Fields& fields, Protocol protocol, std::size_t total,
                                       const BytesOf& bytes_of) {
  std::size_t end = 0;
  const auto follows = [&](const auto& field) {
    const std::size_t offset = field.OffsetIn(protocol);
    if (offset == kAbsent) return true;
    const bool does = offset == end;
    end += bytes_of(field);
    return does;
  };
  return std::apply([&](const auto&... field) { return (follows(field) && ...); }, fields) &&
         end == total;
}

template <Protocol kProtocol>
inline constexpr auto kBytesInState = []<typename Field>(const Field& /*field*/) {
  return kStateFieldBytes<kProtocol, typename Field::Type>;
};

static_assert(IsGapless(kStateFields, Protocol::k5, kStateBytes, kBytesInState<Protocol::k5>));
static_assert(IsGapless(kStateFields, Protocol::k10, kState10Bytes, kBytesInState<Protocol::k10>));
static_assert(IsGapless(kCommandFields, Protocol::k5, kCommandBytes, kBytesInState<Protocol::k5>));
static_assert(IsGapless(kHandStateFields, Protocol::k5, kHandStateBytes,
                        kBytesInState<Protocol::k5>));
static_assert(IsGapless(kVacuumStateFields, Protocol::k5, kVacuumStateBytes,
                        kBytesInState<Protocol::k5>));

}  // namespace twin::fci
