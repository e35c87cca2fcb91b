#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "fci/frame_bytes.h"
#include "fci/message_fields.h"
#include "twin/fci/requests.h"

// Requests to a device on the flange. The devices number the same kinds of messages differently.
namespace twin::fci {

/// @tparam Id  of the device's commands.
template <typename Message, typename Id>
std::variant<HandRequest, BadFrame> ParseAs(const Frame& frame) {
  Message message;
  const std::string_view name = Name(static_cast<Id>(frame.head.command));
  if (auto bad = wire::ReadRequest(name, frame.payload, message)) return *std::move(bad);
  if constexpr (std::is_same_v<Message, Connect>) {
    return HandRequest(message);
  } else {
    return HandRequest(HandCommand(message));
  }
}

/// @tparam Numbers  maps each message of the device to its command.
template <typename Numbers>
std::vector<std::byte> EncodeWith(std::uint32_t command_id, const HandRequest& request) {
  const auto encode = [command_id]<typename Message>(const Message& message) {
    NewFrame frame(Numbers()(message), command_id, wire::kPayload<Message>);
    wire::PutFields(frame.payload(), message);
    return std::move(frame).Release();
  };
  if (const auto* connect = std::get_if<Connect>(&request)) return encode(*connect);
  return std::visit(encode, std::get<HandCommand>(request));
}

}  // namespace twin::fci
