#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <span>
#include <string_view>

#include <google/protobuf/repeated_field.h>

#include "record/log.pb.h"
#include "twin/core/robot_state.h"
#include "twin/record/cycle_record.h"

namespace twin::record {

/// Messages of the log, generated from log.proto.
namespace pb = ::panda_twin;

/// A fixed-size vector of a record, with the repeated field that carries it in the message.
template <class Record, class Message>
struct VectorField {
  std::string_view name;
  std::span<const double> (*values)(const Record&);
  std::span<double> (*mutable_values)(Record&);
  google::protobuf::RepeatedField<double>* (*repeated)(Message&);
};

/// `Member` of a record; for a cycle also a member of its robot state.
template <auto Member, class Record>
constexpr auto& Get(Record& record) {
  if constexpr (requires { record.*Member; }) {
    return record.*Member;
  } else {
    return record.state.*Member;
  }
}

/// Pairs the vector `Member` with the repeated field from `Mutable`.
template <class Record, class Message, auto Member, auto Mutable>
constexpr VectorField<Record, Message> Pair(std::string_view name) {
  return {
      .name = name,
      .values = [](const Record& r) { return std::span<const double>(Get<Member>(r)); },
      .mutable_values = [](Record& r) { return std::span<double>(Get<Member>(r)); },
      .repeated = [](Message& m) { return (m.*Mutable)(); },
  };
}

template <auto Member, auto Mutable>
constexpr auto CycleField(std::string_view name) {
  return Pair<CycleRecord, pb::Cycle, Member, Mutable>(name);
}
template <auto Member, auto Mutable>
constexpr auto ConfigField(std::string_view name) {
  return Pair<RobotState, pb::Config, Member, Mutable>(name);
}
template <auto Member, auto Mutable>
constexpr auto TickField(std::string_view name) {
  return Pair<TickRecord, pb::Tick, Member, Mutable>(name);
}
template <auto Member, auto Mutable>
constexpr auto CommandField(std::string_view name) {
  return Pair<RobotCommand, pb::Command, Member, Mutable>(name);
}

// clang-format off
/// Vectors of topic /robot/cycle.
inline constexpr std::array kCycleFields = {
    CycleField<&RobotState::q, &pb::Cycle::mutable_q>("q"),
    CycleField<&RobotState::q_d, &pb::Cycle::mutable_q_d>("q_d"),
    CycleField<&RobotState::dq, &pb::Cycle::mutable_dq>("dq"),
    CycleField<&RobotState::dq_d, &pb::Cycle::mutable_dq_d>("dq_d"),
    CycleField<&RobotState::ddq_d, &pb::Cycle::mutable_ddq_d>("ddq_d"),
    CycleField<&CycleRecord::dddq_d, &pb::Cycle::mutable_dddq_d>("dddq_d"),
    CycleField<&RobotState::theta, &pb::Cycle::mutable_theta>("theta"),
    CycleField<&RobotState::dtheta, &pb::Cycle::mutable_dtheta>("dtheta"),
    CycleField<&RobotState::tau_J, &pb::Cycle::mutable_tau_j>("tau_J"),
    CycleField<&RobotState::tau_J_d, &pb::Cycle::mutable_tau_j_d>("tau_J_d"),
    CycleField<&RobotState::dtau_J, &pb::Cycle::mutable_dtau_j>("dtau_J"),
    CycleField<&RobotState::tau_ext_hat_filtered, &pb::Cycle::mutable_tau_ext_hat_filtered>(
        "tau_ext_hat_filtered"),
    CycleField<&RobotState::joint_contact, &pb::Cycle::mutable_joint_contact>("joint_contact"),
    CycleField<&RobotState::joint_collision, &pb::Cycle::mutable_joint_collision>(
        "joint_collision"),
    CycleField<&RobotState::cartesian_contact, &pb::Cycle::mutable_cartesian_contact>(
        "cartesian_contact"),
    CycleField<&RobotState::cartesian_collision, &pb::Cycle::mutable_cartesian_collision>(
        "cartesian_collision"),
    CycleField<&RobotState::O_T_EE, &pb::Cycle::mutable_o_t_ee>("O_T_EE"),
    CycleField<&RobotState::O_T_EE_d, &pb::Cycle::mutable_o_t_ee_d>("O_T_EE_d"),
    CycleField<&RobotState::O_T_EE_c, &pb::Cycle::mutable_o_t_ee_c>("O_T_EE_c"),
    CycleField<&RobotState::O_F_ext_hat_K, &pb::Cycle::mutable_o_f_ext_hat_k>("O_F_ext_hat_K"),
    CycleField<&RobotState::K_F_ext_hat_K, &pb::Cycle::mutable_k_f_ext_hat_k>("K_F_ext_hat_K"),
    CycleField<&RobotState::O_dP_EE_d, &pb::Cycle::mutable_o_dp_ee_d>("O_dP_EE_d"),
    CycleField<&RobotState::O_dP_EE_c, &pb::Cycle::mutable_o_dp_ee_c>("O_dP_EE_c"),
    CycleField<&RobotState::O_ddP_EE_c, &pb::Cycle::mutable_o_ddp_ee_c>("O_ddP_EE_c"),
    CycleField<&RobotState::elbow, &pb::Cycle::mutable_elbow>("elbow"),
    CycleField<&RobotState::elbow_d, &pb::Cycle::mutable_elbow_d>("elbow_d"),
    CycleField<&RobotState::elbow_c, &pb::Cycle::mutable_elbow_c>("elbow_c"),
    CycleField<&RobotState::delbow_c, &pb::Cycle::mutable_delbow_c>("delbow_c"),
    CycleField<&RobotState::ddelbow_c, &pb::Cycle::mutable_ddelbow_c>("ddelbow_c"),
};

/// Vectors of topic /robot/config.
inline constexpr std::array kConfigFields = {
    ConfigField<&RobotState::I_ee, &pb::Config::mutable_i_ee>("I_ee"),
    ConfigField<&RobotState::F_x_Cee, &pb::Config::mutable_f_x_cee>("F_x_Cee"),
    ConfigField<&RobotState::I_load, &pb::Config::mutable_i_load>("I_load"),
    ConfigField<&RobotState::F_x_Cload, &pb::Config::mutable_f_x_cload>("F_x_Cload"),
    ConfigField<&RobotState::F_T_EE, &pb::Config::mutable_f_t_ee>("F_T_EE"),
    ConfigField<&RobotState::EE_T_K, &pb::Config::mutable_ee_t_k>("EE_T_K"),
    ConfigField<&RobotState::F_T_NE, &pb::Config::mutable_f_t_ne>("F_T_NE"),
    ConfigField<&RobotState::NE_T_EE, &pb::Config::mutable_ne_t_ee>("NE_T_EE"),
    ConfigField<&RobotState::O_ddP_O, &pb::Config::mutable_o_ddp_o>("O_ddP_O"),
};

/// Vectors of topic /ext/tick, without the command's.
inline constexpr std::array kTickFields = {
    TickField<&TickRecord::q_ext, &pb::Tick::mutable_q_ext>("q_ext"),
    TickField<&TickRecord::dq_ext, &pb::Tick::mutable_dq_ext>("dq_ext"),
};

/// Vectors of the command in a tick.
inline constexpr std::array kCommandFields = {
    CommandField<&RobotCommand::q_c, &pb::Command::mutable_q_c>("q_c"),
    CommandField<&RobotCommand::dq_c, &pb::Command::mutable_dq_c>("dq_c"),
    CommandField<&RobotCommand::O_T_EE_c, &pb::Command::mutable_o_t_ee_c>("O_T_EE_c"),
    CommandField<&RobotCommand::O_dP_EE_c, &pb::Command::mutable_o_dp_ee_c>("O_dP_EE_c"),
    CommandField<&RobotCommand::elbow_c, &pb::Command::mutable_elbow_c>("elbow_c"),
    CommandField<&RobotCommand::tau_J_d, &pb::Command::mutable_tau_j_d>("tau_J_d"),
};
// clang-format on

/// Names of the topics.
inline constexpr std::string_view kCycleTopic = "/robot/cycle";
inline constexpr std::string_view kConfigTopic = "/robot/config";
inline constexpr std::string_view kTickTopic = "/ext/tick";
inline constexpr std::string_view kEventTopic = "/event";
inline constexpr std::string_view kFramesTopic = "/tf";
inline constexpr std::string_view kSceneTopic = "/scene";
inline constexpr std::string_view kPlanTopic = "/plan";

/// Names of the metadata records of the run and its limits, the keys of the former, and the
/// attachment with the scenario.
inline constexpr const char* kRunMetadata = "run";
inline constexpr const char* kLimitsMetadata = "limits";
inline constexpr const char* kScenarioKey = "scenario";
inline constexpr const char* kSeedKey = "seed";
inline constexpr const char* kVersionKey = "version";
inline constexpr const char* kDriveKey = "drive";
inline constexpr const char* kScenarioAttachment = "scenario.yaml";

/// True if two states agree bit by bit in the fields of topic /robot/config.
[[nodiscard]] inline bool SameConfig(const RobotState& a, const RobotState& b) {
  for (const auto& field : kConfigFields) {
    const auto values = field.values(a);
    if (std::memcmp(values.data(), field.values(b).data(), values.size_bytes()) != 0) return false;
  }
  return std::bit_cast<std::uint64_t>(a.m_ee) == std::bit_cast<std::uint64_t>(b.m_ee) &&
         std::bit_cast<std::uint64_t>(a.m_load) == std::bit_cast<std::uint64_t>(b.m_load);
}

}  // namespace twin::record
