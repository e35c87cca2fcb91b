#include <fmt/format.h>

#include "fci/frame_bytes.h"
#include "fci/message_fields.h"
#include "twin/fci/requests.h"

namespace twin::fci {
namespace {

using ParsedHandRequest = std::variant<HandRequest, BadFrame>;

template <typename Message>
ParsedHandRequest ParseHand(const Frame& frame) {
  Message message;
  const std::string_view name = Name(static_cast<HandCommandId>(frame.head.command));
  if (auto bad = wire::ReadRequest(name, frame.payload, message)) return *std::move(bad);
  if constexpr (std::is_same_v<Message, Connect>) {
    return HandRequest(message);
  } else {
    return HandRequest(HandCommand(message));
  }
}

/// Maps each message to its command.
struct HandCommander {
  HandCommandId operator()(const Connect&) { return HandCommandId::kConnect; }
  HandCommandId operator()(const hand::Homing&) { return HandCommandId::kHoming; }
  HandCommandId operator()(const hand::Grasp&) { return HandCommandId::kGrasp; }
  HandCommandId operator()(const hand::Move&) { return HandCommandId::kMove; }
  HandCommandId operator()(const hand::Stop&) { return HandCommandId::kStop; }
};

template <typename Message>
std::vector<std::byte> EncodeHandMessage(std::uint32_t command_id, const Message& message) {
  NewFrame frame(HandCommander()(message), command_id, wire::kPayload<Message>);
  wire::PutFields(frame.payload(), message);
  return std::move(frame).Release();
}

std::vector<std::byte> EncodeHandMessage(std::uint32_t command_id, const HandCommand& command) {
  return std::visit([command_id](const auto& one) { return EncodeHandMessage(command_id, one); },
                    command);
}

}  // namespace

ParsedHandRequest ParseHandRequest(const Frame& frame) {
  // The hand's head has a 16-bit command; a larger one cannot come from a stream.
  switch (frame.head.command) {
    case static_cast<std::uint32_t>(HandCommandId::kConnect): return ParseHand<Connect>(frame);
    case static_cast<std::uint32_t>(HandCommandId::kHoming): return ParseHand<hand::Homing>(frame);
    case static_cast<std::uint32_t>(HandCommandId::kGrasp): return ParseHand<hand::Grasp>(frame);
    case static_cast<std::uint32_t>(HandCommandId::kMove): return ParseHand<hand::Move>(frame);
    case static_cast<std::uint32_t>(HandCommandId::kStop): return ParseHand<hand::Stop>(frame);
    default: break;
  }
  return BadFrame{fmt::format("command {} is none of the hand's, which are 0 to {}",
                              frame.head.command, kHandCommands - 1)};
}

std::vector<std::byte> EncodeRequest(std::uint32_t command_id, const HandRequest& request) {
  return std::visit([command_id](const auto& one) { return EncodeHandMessage(command_id, one); },
                    request);
}

}  // namespace twin::fci
