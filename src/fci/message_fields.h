#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <tuple>

#include <fmt/format.h>

#include "fci/wire.h"
#include "twin/fci/requests.h"

// Payload of each TCP message: its fields in wire order, in one table for both directions. The
// compiler checks the sizes below. Source: FCI protocol 5, request and response payloads, gripper
// commands.
namespace twin::fci::wire {

/// One field of a message.
template <typename Struct, typename Value>
struct Field {
  std::string_view name;  ///< in transcripts
  Value Struct::*member;
};
template <typename Struct, typename Value>
Field(std::string_view, Value Struct::*) -> Field<Struct, Value>;

/// The fields of a T; none for an empty payload.
template <typename T>
inline constexpr std::tuple<> kFields{};
template <>
inline constexpr std::tuple kFields<Connect>{Field{"version", &Connect::version},
                                             Field{"udp_port", &Connect::udp_port}};
template <>
inline constexpr std::tuple kFields<Move>{
    Field{"modes", &Move::modes}, Field{"maximum_path_deviation", &Move::maximum_path_deviation},
    Field{"maximum_goal_pose_deviation", &Move::maximum_goal_pose_deviation}};
template <>
inline constexpr std::tuple kFields<GetCartesianLimit>{Field{"id", &GetCartesianLimit::id}};
template <>
inline constexpr std::tuple kFields<LoadModelLibrary>{
    Field{"architecture", &LoadModelLibrary::architecture},
    Field{"system", &LoadModelLibrary::system}};
template <>
inline constexpr std::tuple kFields<setting::CollisionBehavior>{
    Field{"lower_torque_acc", &setting::CollisionBehavior::lower_torque_acc},
    Field{"upper_torque_acc", &setting::CollisionBehavior::upper_torque_acc},
    Field{"lower_torque_nominal", &setting::CollisionBehavior::lower_torque_nominal},
    Field{"upper_torque_nominal", &setting::CollisionBehavior::upper_torque_nominal},
    Field{"lower_force_acc", &setting::CollisionBehavior::lower_force_acc},
    Field{"upper_force_acc", &setting::CollisionBehavior::upper_force_acc},
    Field{"lower_force_nominal", &setting::CollisionBehavior::lower_force_nominal},
    Field{"upper_force_nominal", &setting::CollisionBehavior::upper_force_nominal}};
template <>
inline constexpr std::tuple kFields<setting::JointImpedance>{
    Field{"K_theta", &setting::JointImpedance::K_theta}};
template <>
inline constexpr std::tuple kFields<setting::CartesianImpedance>{
    Field{"K_x", &setting::CartesianImpedance::K_x}};
template <>
inline constexpr std::tuple kFields<setting::GuidingMode>{
    Field{"guiding_mode", &setting::GuidingMode::axes},
    Field{"nullspace", &setting::GuidingMode::elbow}};
template <>
inline constexpr std::tuple kFields<setting::StiffnessFrame>{
    Field{"EE_T_K", &setting::StiffnessFrame::EE_T_K}};
template <>
inline constexpr std::tuple kFields<setting::EndEffectorFrame>{
    Field{"NE_T_EE", &setting::EndEffectorFrame::NE_T_EE}};
template <>
inline constexpr std::tuple kFields<setting::Load>{Field{"m_load", &setting::Load::m_load},
                                                   Field{"F_x_Cload", &setting::Load::F_x_Cload},
                                                   Field{"I_load", &setting::Load::I_load}};
template <>
inline constexpr std::tuple kFields<setting::Filters>{
    Field{"joint_position_hz", &setting::Filters::joint_position_hz},
    Field{"joint_velocity_hz", &setting::Filters::joint_velocity_hz},
    Field{"cartesian_position_hz", &setting::Filters::cartesian_position_hz},
    Field{"cartesian_velocity_hz", &setting::Filters::cartesian_velocity_hz},
    Field{"controller_hz", &setting::Filters::controller_hz}};
template <>
inline constexpr std::tuple kFields<hand::Grasp>{
    Field{"width", &hand::Grasp::width}, Field{"epsilon_inner", &hand::Grasp::epsilon_inner},
    Field{"epsilon_outer", &hand::Grasp::epsilon_outer}, Field{"speed", &hand::Grasp::speed},
    Field{"force", &hand::Grasp::force}};
template <>
inline constexpr std::tuple kFields<hand::Move>{Field{"width", &hand::Move::width},
                                                Field{"speed", &hand::Move::speed}};
template <>
inline constexpr std::tuple kFields<hand::Vacuum>{Field{"vacuum", &hand::Vacuum::vacuum},
                                                  Field{"profile", &hand::Vacuum::profile},
                                                  Field{"timeout_ms", &hand::Vacuum::timeout_ms}};
template <>
inline constexpr std::tuple kFields<hand::DropOff>{Field{"timeout_ms", &hand::DropOff::timeout_ms}};
template <>
inline constexpr std::tuple kFields<CartesianLimit>{
    Field{"object_world_size", &CartesianLimit::object_world_size},
    Field{"object_frame", &CartesianLimit::object_frame},
    Field{"object_activation", &CartesianLimit::object_activation}};

/// The fields of a T in a protocol.
template <typename T, Protocol kProtocol>
inline constexpr auto kFieldsIn = kFields<T>;
template <>
inline constexpr auto kFieldsIn<Move, Protocol::k10> =
    std::tuple_cat(kFields<Move>, std::tuple{Field{"asynchronous", &Move::asynchronous},
                                             Field{"maximum_velocity", &Move::maximum_velocity}});

template <typename T, typename Value>
[[nodiscard]] constexpr std::size_t BytesOf(const Field<T, Value>& /*field*/) {
  return kBytes<Value>;
}

/// Bytes of T's payload.
template <typename T, Protocol kProtocol = Protocol::k5>
inline constexpr std::size_t kPayload = std::apply(
    [](auto... field) { return (std::size_t{0} + ... + BytesOf(field)); }, kFieldsIn<T, kProtocol>);

static_assert(kPayload<Connect> == 4);
static_assert(kPayload<Move> == 56);
static_assert(kPayload<Move, Protocol::k10> == 113);
static_assert(kPayload<StopMove> == 0);
static_assert(kPayload<GetCartesianLimit> == 4);
static_assert(kPayload<setting::CollisionBehavior> == 416);
static_assert(kPayload<setting::JointImpedance> == 56);
static_assert(kPayload<setting::CartesianImpedance> == 48);
static_assert(kPayload<setting::GuidingMode> == 7);
static_assert(kPayload<setting::StiffnessFrame> == 128);
static_assert(kPayload<setting::EndEffectorFrame> == 128);
static_assert(kPayload<setting::Load> == 104);
static_assert(kPayload<setting::Filters> == 40);
static_assert(kPayload<AutomaticErrorRecovery> == 0);
static_assert(kPayload<LoadModelLibrary> == 2);
static_assert(kPayload<GetRobotModel> == 0);
static_assert(kPayload<hand::Homing> == 0);
static_assert(kPayload<hand::Grasp> == 40);
static_assert(kPayload<hand::Move> == 16);
static_assert(kPayload<hand::Stop> == 0);
static_assert(kPayload<hand::Vacuum> == 10);
static_assert(kPayload<hand::DropOff> == 8);
static_assert(kPayload<CartesianLimit> == 153);
static_assert(kArmHeadBytes + kPayload<setting::CollisionBehavior> == kLargestArmRequest);
static_assert(kHandHeadBytes + kPayload<hand::Grasp> == kLargestHandRequest);

/// @param at  kPayload<T, kProtocol> bytes are written there.
template <Protocol kProtocol = Protocol::k5, typename T>
void PutFields(std::byte* at, const T& message) noexcept {
  const auto put = [&at](const auto& value) {
    Put(at, value);
    at += kBytes<std::remove_cvref_t<decltype(value)>>;
  };
  std::apply([&](auto... field) { (put(message.*(field.member)), ...); }, kFieldsIn<T, kProtocol>);
}

/// @param at  kPayload<T, kProtocol> bytes are read from there.
/// @returns true if all flags are 0 or 1; otherwise some fields may have been written.
template <Protocol kProtocol = Protocol::k5, typename T>
[[nodiscard]] bool TakeFields(const std::byte* at, T& message) noexcept {
  const auto take = [&at](auto& value) {
    using Value = std::remove_cvref_t<decltype(value)>;
    if constexpr (kIsFlags<Value>) {
      if (!AreFlags({at, kBytes<Value>})) return false;
    }
    Take(at, value);
    at += kBytes<Value>;
    return true;
  };
  return std::apply([&](auto... field) { return (take(message.*(field.member)) && ...); },
                    kFieldsIn<T, kProtocol>);
}

/// The error for a payload with a flag other than 0 or 1.
[[nodiscard]] inline BadFrame BadFlag(std::string_view name) {
  return {fmt::format("{}: a flag is neither 0 nor 1", name)};
}

/// Reads a request's payload, whose size must match exactly.
/// @param name  of the request, for the message.
template <Protocol kProtocol = Protocol::k5, typename T>
[[nodiscard]] std::optional<BadFrame> ReadRequest(std::string_view name,
                                                  std::span<const std::byte> payload, T& message) {
  constexpr std::size_t kNeeded = kPayload<T, kProtocol>;
  if (payload.size() != kNeeded) {
    return BadFrame{
        fmt::format("{}: {} bytes of payload, {} are needed", name, payload.size(), kNeeded)};
  }
  if (!TakeFields<kProtocol>(payload.data(), message)) return BadFlag(name);
  return {};
}

}  // namespace twin::fci::wire
