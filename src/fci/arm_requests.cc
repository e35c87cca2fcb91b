#include <algorithm>
#include <array>
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
  if (auto bad = wire::ReadRequest(Message::kName, frame.payload, message)) return *std::move(bad);
  if constexpr (std::is_constructible_v<Setting, Message>) {
    return ArmRequest(Setting(message));
  } else {
    return ArmRequest(message);
  }
}

/// The arm's messages. The index is the command's number on the wire.
template <typename... Message>
struct List {
  static constexpr std::array kNames{Message::kName...};
  static constexpr std::array kParsers{&ParseArm<Message>...};

  template <typename Wanted>
  static constexpr ArmCommand CommandOf() {
    constexpr std::array kIsWanted{std::is_same_v<Wanted, Message>...};
    return static_cast<ArmCommand>(std::ranges::find(kIsWanted, true) - kIsWanted.begin());
  }
};
using ArmMessages = List<Connect, Move, StopMove, GetCartesianLimit, setting::CollisionBehavior,
                         setting::JointImpedance, setting::CartesianImpedance, setting::GuidingMode,
                         setting::StiffnessFrame, setting::EndEffectorFrame, setting::Load,
                         setting::Filters, AutomaticErrorRecovery, LoadModelLibrary>;
static_assert(ArmMessages::kNames.size() == kArmCommands);

/// Calls `take` with the message of the request.
template <typename Take>
auto Visit(const Take& take, const ArmRequest& request) {
  return std::visit(
      [&take]<typename One>(const One& one) {
        if constexpr (std::is_same_v<One, Setting>) {
          return std::visit(take, one);
        } else {
          return take(one);
        }
      },
      request);
}

}  // namespace

ParsedArmRequest ParseArmRequest(const Frame& frame) {
  const std::uint32_t command = frame.head.command;
  if (command < kArmCommands) return ArmMessages::kParsers[command](frame);
  return BadFrame{
      fmt::format("command {} is none of the arm's, which are 0 to {}", command, kArmCommands - 1)};
}

ArmCommand CommandOf(const ArmRequest& request) noexcept {
  return Visit(
      []<typename Message>(const Message& /*unused*/) { return ArmMessages::CommandOf<Message>(); },
      request);
}

std::string_view Name(ArmCommand command) noexcept {
  const auto index = static_cast<std::size_t>(command);
  return index < kArmCommands ? ArmMessages::kNames[index] : "unknown";
}

std::vector<std::byte> EncodeRequest(std::uint32_t command_id, const ArmRequest& request) {
  return Visit(
      [command_id]<typename Message>(const Message& message) {
        NewFrame frame(ArmMessages::CommandOf<Message>(), command_id, wire::kPayload<Message>);
        wire::PutFields(frame.payload(), message);
        return std::move(frame).Release();
      },
      request);
}

}  // namespace twin::fci
