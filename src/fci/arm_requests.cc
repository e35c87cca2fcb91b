#include <type_traits>

#include <fmt/format.h>

#include "fci/frame_bytes.h"
#include "fci/message_fields.h"
#include "twin/fci/requests.h"

namespace twin::fci {
namespace {

using ParsedArmRequest = std::variant<ArmRequest, BadFrame>;

template <typename Message>
ParsedArmRequest ParseArm(const Frame& frame) {
  Message message;
  const std::string_view name = Name(static_cast<ArmCommand>(frame.head.command));
  if (auto bad = wire::ReadRequest(name, frame.payload, message)) return *std::move(bad);
  if constexpr (std::is_constructible_v<Setting, Message>) {
    return ArmRequest(Setting(message));
  } else {
    return ArmRequest(message);
  }
}

/// Maps each message to its command.
struct ArmCommander {
  ArmCommand operator()(const Connect&) { return ArmCommand::kConnect; }
  ArmCommand operator()(const Move&) { return ArmCommand::kMove; }
  ArmCommand operator()(const StopMove&) { return ArmCommand::kStopMove; }
  ArmCommand operator()(const GetCartesianLimit&) { return ArmCommand::kGetCartesianLimit; }
  ArmCommand operator()(const AutomaticErrorRecovery&) {
    return ArmCommand::kAutomaticErrorRecovery;
  }
  ArmCommand operator()(const LoadModelLibrary&) { return ArmCommand::kLoadModelLibrary; }
  ArmCommand operator()(const setting::CollisionBehavior&) {
    return ArmCommand::kSetCollisionBehavior;
  }
  ArmCommand operator()(const setting::JointImpedance&) { return ArmCommand::kSetJointImpedance; }
  ArmCommand operator()(const setting::CartesianImpedance&) {
    return ArmCommand::kSetCartesianImpedance;
  }
  ArmCommand operator()(const setting::GuidingMode&) { return ArmCommand::kSetGuidingMode; }
  ArmCommand operator()(const setting::StiffnessFrame&) { return ArmCommand::kSetEEToK; }
  ArmCommand operator()(const setting::EndEffectorFrame&) { return ArmCommand::kSetNEToEE; }
  ArmCommand operator()(const setting::Load&) { return ArmCommand::kSetLoad; }
  ArmCommand operator()(const setting::Filters&) { return ArmCommand::kSetFilters; }
  ArmCommand operator()(const Setting& setting) { return std::visit(*this, setting); }
};

template <typename Message>
std::vector<std::byte> EncodeArmMessage(std::uint32_t command_id, const Message& message) {
  NewFrame frame(ArmCommander()(message), command_id, wire::kPayload<Message>);
  wire::PutFields(frame.payload(), message);
  return std::move(frame).Release();
}

std::vector<std::byte> EncodeArmMessage(std::uint32_t command_id, const Setting& setting) {
  return std::visit([command_id](const auto& one) { return EncodeArmMessage(command_id, one); },
                    setting);
}

}  // namespace

ParsedArmRequest ParseArmRequest(const Frame& frame) {
  switch (static_cast<ArmCommand>(frame.head.command)) {
    case ArmCommand::kConnect: return ParseArm<Connect>(frame);
    case ArmCommand::kMove: return ParseArm<Move>(frame);
    case ArmCommand::kStopMove: return ParseArm<StopMove>(frame);
    case ArmCommand::kGetCartesianLimit: return ParseArm<GetCartesianLimit>(frame);
    case ArmCommand::kSetCollisionBehavior: return ParseArm<setting::CollisionBehavior>(frame);
    case ArmCommand::kSetJointImpedance: return ParseArm<setting::JointImpedance>(frame);
    case ArmCommand::kSetCartesianImpedance: return ParseArm<setting::CartesianImpedance>(frame);
    case ArmCommand::kSetGuidingMode: return ParseArm<setting::GuidingMode>(frame);
    case ArmCommand::kSetEEToK: return ParseArm<setting::StiffnessFrame>(frame);
    case ArmCommand::kSetNEToEE: return ParseArm<setting::EndEffectorFrame>(frame);
    case ArmCommand::kSetLoad: return ParseArm<setting::Load>(frame);
    case ArmCommand::kSetFilters: return ParseArm<setting::Filters>(frame);
    case ArmCommand::kAutomaticErrorRecovery: return ParseArm<AutomaticErrorRecovery>(frame);
    case ArmCommand::kLoadModelLibrary: return ParseArm<LoadModelLibrary>(frame);
  }
  return BadFrame{fmt::format("command {} is none of the arm's, which are 0 to {}",
                              frame.head.command, kArmCommands - 1)};
}

ArmCommand CommandOf(const ArmRequest& request) noexcept {
  return std::visit(ArmCommander(), request);
}

std::vector<std::byte> EncodeRequest(std::uint32_t command_id, const ArmRequest& request) {
  return std::visit([command_id](const auto& one) { return EncodeArmMessage(command_id, one); },
                    request);
}

}  // namespace twin::fci
