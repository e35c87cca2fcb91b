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
  std::string_view unit;     ///< empty: none, or several
  std::string_view meaning;  ///< with the frame of its axes
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
constexpr VectorField<Record, Message> Pair(std::string_view name, std::string_view unit,
                                            std::string_view meaning) {
  return {
      .name = name,
      .unit = unit,
      .meaning = meaning,
      .values = [](const Record& r) { return std::span<const double>(Get<Member>(r)); },
      .mutable_values = [](Record& r) { return std::span<double>(Get<Member>(r)); },
      .repeated = [](Message& m) { return (m.*Mutable)(); },
  };
}

template <auto Member, auto Mutable>
constexpr auto CycleField(std::string_view name, std::string_view unit, std::string_view meaning) {
  return Pair<CycleRecord, pb::Cycle, Member, Mutable>(name, unit, meaning);
}
template <auto Member, auto Mutable>
constexpr auto ConfigField(std::string_view name, std::string_view unit, std::string_view meaning) {
  return Pair<RobotState, pb::Config, Member, Mutable>(name, unit, meaning);
}
template <auto Member, auto Mutable>
constexpr auto TickField(std::string_view name, std::string_view unit, std::string_view meaning) {
  return Pair<TickRecord, pb::Tick, Member, Mutable>(name, unit, meaning);
}
template <auto Member, auto Mutable>
constexpr auto CommandField(std::string_view name, std::string_view unit,
                            std::string_view meaning) {
  return Pair<RobotCommand, pb::Command, Member, Mutable>(name, unit, meaning);
}

// clang-format off
/// Vectors of topic /robot/cycle.
inline constexpr std::array kCycleFields = {
    CycleField<&RobotState::q, &pb::Cycle::mutable_q>("q", "rad",
        "Measured joint positions"),
    CycleField<&RobotState::q_d, &pb::Cycle::mutable_q_d>("q_d", "rad",
        "Desired joint positions"),
    CycleField<&RobotState::dq, &pb::Cycle::mutable_dq>("dq", "rad/s",
        "Measured joint velocities"),
    CycleField<&RobotState::dq_d, &pb::Cycle::mutable_dq_d>("dq_d", "rad/s",
        "Desired joint velocities"),
    CycleField<&RobotState::ddq_d, &pb::Cycle::mutable_ddq_d>("ddq_d", "rad/s^2",
        "Desired joint accelerations"),
    CycleField<&CycleRecord::dddq_d, &pb::Cycle::mutable_dddq_d>("dddq_d", "rad/s^3",
        "Jerk of the reference, by backward differences"),
    CycleField<&RobotState::theta, &pb::Cycle::mutable_theta>("theta", "rad",
        "Motor positions"),
    CycleField<&RobotState::dtheta, &pb::Cycle::mutable_dtheta>("dtheta", "rad/s",
        "Motor velocities"),
    CycleField<&RobotState::tau_J, &pb::Cycle::mutable_tau_j>("tau_J", "Nm",
        "Measured joint torques, gravity included"),
    CycleField<&RobotState::tau_J_d, &pb::Cycle::mutable_tau_j_d>("tau_J_d", "Nm",
        "Desired joint torques, without gravity and friction"),
    CycleField<&RobotState::dtau_J, &pb::Cycle::mutable_dtau_j>("dtau_J", "Nm/s",
        "Derivative of tau_J"),
    CycleField<&RobotState::tau_ext_hat_filtered, &pb::Cycle::mutable_tau_ext_hat_filtered>("tau_ext_hat_filtered", "Nm",
        "Estimated external joint torques, filtered"),
    CycleField<&RobotState::joint_contact, &pb::Cycle::mutable_joint_contact>("joint_contact", "",
        "Contact level of each joint"),
    CycleField<&RobotState::joint_collision, &pb::Cycle::mutable_joint_collision>("joint_collision", "",
        "Collision level of each joint"),
    CycleField<&RobotState::cartesian_contact, &pb::Cycle::mutable_cartesian_contact>("cartesian_contact", "",
        "Contact level of x, y, z, R, P, Y in K"),
    CycleField<&RobotState::cartesian_collision, &pb::Cycle::mutable_cartesian_collision>("cartesian_collision", "",
        "Collision level of x, y, z, R, P, Y in K"),
    CycleField<&RobotState::O_T_EE, &pb::Cycle::mutable_o_t_ee>("O_T_EE", "",
        "Measured pose of EE in O, 4 x 4, column-major; m"),
    CycleField<&RobotState::O_T_EE_d, &pb::Cycle::mutable_o_t_ee_d>("O_T_EE_d", "",
        "Desired pose of EE in O, 4 x 4, column-major; m"),
    CycleField<&RobotState::O_T_EE_c, &pb::Cycle::mutable_o_t_ee_c>("O_T_EE_c", "",
        "Last commanded pose of EE in O, 4 x 4, column-major; m"),
    CycleField<&RobotState::O_F_ext_hat_K, &pb::Cycle::mutable_o_f_ext_hat_k>("O_F_ext_hat_K", "N, Nm",
        "Estimated external wrench at K, axes of O; positive: the robot pushes on its environment"),
    CycleField<&RobotState::K_F_ext_hat_K, &pb::Cycle::mutable_k_f_ext_hat_k>("K_F_ext_hat_K", "N, Nm",
        "The same in axes of K"),
    CycleField<&RobotState::O_dP_EE_d, &pb::Cycle::mutable_o_dp_ee_d>("O_dP_EE_d", "m/s, rad/s",
        "Desired twist of EE, axes of O"),
    CycleField<&RobotState::O_dP_EE_c, &pb::Cycle::mutable_o_dp_ee_c>("O_dP_EE_c", "m/s, rad/s",
        "Last commanded twist of EE, axes of O"),
    CycleField<&RobotState::O_ddP_EE_c, &pb::Cycle::mutable_o_ddp_ee_c>("O_ddP_EE_c", "m/s^2, rad/s^2",
        "Last commanded acceleration of EE, axes of O"),
    CycleField<&RobotState::elbow, &pb::Cycle::mutable_elbow>("elbow", "",
        "Measured elbow: position of joint 3, rad; sign of joint 4"),
    CycleField<&RobotState::elbow_d, &pb::Cycle::mutable_elbow_d>("elbow_d", "",
        "Desired elbow, as elbow"),
    CycleField<&RobotState::elbow_c, &pb::Cycle::mutable_elbow_c>("elbow_c", "",
        "Last commanded elbow, as elbow"),
    CycleField<&RobotState::delbow_c, &pb::Cycle::mutable_delbow_c>("delbow_c", "",
        "Velocity of elbow_c"),
    CycleField<&RobotState::ddelbow_c, &pb::Cycle::mutable_ddelbow_c>("ddelbow_c", "",
        "Acceleration of elbow_c"),
};

/// Vectors of topic /robot/config.
inline constexpr std::array kConfigFields = {
    ConfigField<&RobotState::I_ee, &pb::Config::mutable_i_ee>("I_ee", "kg m^2",
        "Inertia of the end effector about its centre of mass, 3 x 3, column-major, axes of F"),
    ConfigField<&RobotState::F_x_Cee, &pb::Config::mutable_f_x_cee>("F_x_Cee", "m",
        "Centre of mass of the end effector in F"),
    ConfigField<&RobotState::I_load, &pb::Config::mutable_i_load>("I_load", "kg m^2",
        "Inertia of the load about its centre of mass, 3 x 3, column-major, axes of F"),
    ConfigField<&RobotState::F_x_Cload, &pb::Config::mutable_f_x_cload>("F_x_Cload", "m",
        "Centre of mass of the load in F"),
    ConfigField<&RobotState::F_T_EE, &pb::Config::mutable_f_t_ee>("F_T_EE", "",
        "Pose of EE in F, 4 x 4, column-major; m"),
    ConfigField<&RobotState::EE_T_K, &pb::Config::mutable_ee_t_k>("EE_T_K", "",
        "Pose of K in EE, 4 x 4, column-major; m"),
    ConfigField<&RobotState::F_T_NE, &pb::Config::mutable_f_t_ne>("F_T_NE", "",
        "Pose of NE in F, 4 x 4, column-major; m"),
    ConfigField<&RobotState::NE_T_EE, &pb::Config::mutable_ne_t_ee>("NE_T_EE", "",
        "Pose of EE in NE, 4 x 4, column-major; m"),
    ConfigField<&RobotState::O_ddP_O, &pb::Config::mutable_o_ddp_o>("O_ddP_O", "m/s^2",
        "Gravity in O"),
};

/// Vectors of topic /ext/tick, without the command's.
inline constexpr std::array kTickFields = {
    TickField<&TickRecord::q_ext, &pb::Tick::mutable_q_ext>("q_ext", "rad",
        "Deposited target after rate matching, or the present position of the source in a resampler"),
    TickField<&TickRecord::dq_ext, &pb::Tick::mutable_dq_ext>("dq_ext", "rad/s",
        "Velocity of q_ext"),
};

/// Vectors of the command in a tick.
inline constexpr std::array kCommandFields = {
    CommandField<&RobotCommand::q_c, &pb::Command::mutable_q_c>("q_c", "rad",
        "Commanded joint positions"),
    CommandField<&RobotCommand::dq_c, &pb::Command::mutable_dq_c>("dq_c", "rad/s",
        "Commanded joint velocities"),
    CommandField<&RobotCommand::O_T_EE_c, &pb::Command::mutable_o_t_ee_c>("O_T_EE_c", "",
        "Commanded pose of EE in O, 4 x 4, column-major; m"),
    CommandField<&RobotCommand::O_dP_EE_c, &pb::Command::mutable_o_dp_ee_c>("O_dP_EE_c", "m/s, rad/s",
        "Commanded twist of EE, axes of O"),
    CommandField<&RobotCommand::elbow_c, &pb::Command::mutable_elbow_c>("elbow_c", "",
        "Commanded elbow, with valid_elbow: position of joint 3, rad; sign of joint 4"),
    CommandField<&RobotCommand::tau_J_d, &pb::Command::mutable_tau_j_d>("tau_J_d", "Nm",
        "Commanded joint torques, without gravity and friction"),
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
