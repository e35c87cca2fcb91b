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

/// All messages of the arm, in the order of ArmCommand.
template <typename... Message>
struct AllOf {
  static constexpr std::array kNames{Message::kName...};

  template <typename Wanted>
  static constexpr ArmCommand CommandOf() {
    constexpr std::array kIsWanted{std::is_same_v<Wanted, Message>...};
    return static_cast<ArmCommand>(std::ranges::find(kIsWanted, true) - kIsWanted.begin());
  }
};
using AllMessages =
    AllOf<Connect, Move, StopMove, GetCartesianLimit, setting::CollisionBehavior,
          setting::JointImpedance, setting::CartesianImpedance, setting::GuidingMode,
          setting::StiffnessFrame, setting::EndEffectorFrame, setting::Load, setting::Filters,
          AutomaticErrorRecovery, LoadModelLibrary, GetRobotModel>;
static_assert(AllMessages::CommandOf<GetRobotModel>() == ArmCommand::kGetRobotModel);

template <typename Message, Protocol kProtocol>
ParsedArmRequest ParseArm(const Frame& frame) {
  Message message;
  if (auto bad = wire::ReadRequest<kProtocol>(Message::kName, frame.payload, message)) {
    return *std::move(bad);
  }
  if constexpr (std::is_same_v<Message, Move> && kProtocol == Protocol::k5) {
    MotionGeneratorMode& generator = message.modes.generator;
    if (generator == MotionGeneratorMode::kNone) generator = MotionGeneratorMode::kIdle;
  }
  if constexpr (std::is_constructible_v<Setting, Message>) {
    return ArmRequest(Setting(message));
  } else {
    return ArmRequest(message);
  }
}

constexpr std::uint32_t kNone = static_cast<std::uint32_t>(-1);

/// A protocol's messages. The index is the command's number on the wire.
template <Protocol kProtocol, typename... Message>
struct List {
  static constexpr std::array kParsers{&ParseArm<Message, kProtocol>...};
  static constexpr std::array kCommands{AllMessages::CommandOf<Message>()...};

  /// kNone when the protocol has no such message.
  static constexpr std::uint32_t NumberOf(ArmCommand command) {
    for (std::uint32_t i = 0; i < kCommands.size(); ++i) {
      if (kCommands[i] == command) return i;
    }
    return kNone;
  }
};
using ArmMessages5 =
    List<Protocol::k5, Connect, Move, StopMove, GetCartesianLimit, setting::CollisionBehavior,
         setting::JointImpedance, setting::CartesianImpedance, setting::GuidingMode,
         setting::StiffnessFrame, setting::EndEffectorFrame, setting::Load, setting::Filters,
         AutomaticErrorRecovery, LoadModelLibrary>;
using ArmMessages10 = List<Protocol::k10, Connect, Move, StopMove, setting::CollisionBehavior,
                           setting::JointImpedance, setting::CartesianImpedance,
                           setting::GuidingMode, setting::StiffnessFrame, setting::EndEffectorFrame,
                           setting::Load, AutomaticErrorRecovery, GetRobotModel>;

template <typename Messages>
ParsedArmRequest Parse(const Frame& frame) {
  const std::uint32_t number = frame.head.command;
  if (number < Messages::kParsers.size()) return Messages::kParsers[number](frame);
  return BadFrame{fmt::format("command {} is none of the arm's, which are 0 to {}", number,
                              Messages::kParsers.size() - 1)};
}

/// Calls `with` with the list of the protocol's messages.
template <typename With>
auto InProtocol(Protocol protocol, const With& with) {
  return protocol == Protocol::k5 ? with(ArmMessages5()) : with(ArmMessages10());
}

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

ParsedArmRequest ParseArmRequest(const Frame& frame, Protocol protocol) {
  return InProtocol(protocol, [&]<typename List>(List) { return Parse<List>(frame); });
}

ArmCommand CommandOf(const ArmRequest& request) noexcept {
  return Visit(
      []<typename Message>(const Message& /*unused*/) { return AllMessages::CommandOf<Message>(); },
      request);
}

std::optional<std::uint32_t> NumberOf(Protocol protocol, ArmCommand command) noexcept {
  const std::uint32_t number =
      InProtocol(protocol, [&]<typename List>(List) { return List::NumberOf(command); });
  return number == kNone ? std::nullopt : std::optional(number);
}

std::optional<ArmCommand> ArmCommandAt(Protocol protocol, std::uint32_t number) noexcept {
  return InProtocol(protocol, [&]<typename List>(List) -> std::optional<ArmCommand> {
    if (number >= List::kCommands.size()) return {};
    return List::kCommands[number];
  });
}

std::string_view Name(ArmCommand command) noexcept {
  const auto index = static_cast<std::size_t>(command);
  return index < AllMessages::kNames.size() ? AllMessages::kNames[index] : "unknown";
}

std::vector<std::byte> EncodeRequest(std::uint32_t command_id, const ArmRequest& request,
                                     Protocol protocol) {
  const auto encode = [&]<Protocol kProtocol, typename Message>(const Message& message) {
    NewFrame frame(NumberOf(kProtocol, AllMessages::CommandOf<Message>()).value(), command_id,
                   wire::kPayload<Message, kProtocol>);
    wire::PutFields<kProtocol>(frame.payload(), message);
    return std::move(frame).Release();
  };
  return Visit(
      [&](const auto& message) {
        return protocol == Protocol::k5 ? encode.template operator()<Protocol::k5>(message)
                                        : encode.template operator()<Protocol::k10>(message);
      },
      request);
}

}  // namespace twin::fci
