#include "twin/fci/hand_session.h"

#include <algorithm>
#include <utility>
#include <variant>

#include <fmt/format.h>

namespace twin::fci {

HandSession::HandSession(HandService& service, Answers answers)
    : service_(service), answers_(std::move(answers)) {}

std::optional<std::string> HandSession::OnFrame(const Frame& frame) {
  const std::variant<HandRequest, BadFrame> parsed = ParseHandRequest(frame);
  if (const auto* bad = std::get_if<BadFrame>(&parsed)) return bad->what;
  const auto& request = std::get<HandRequest>(parsed);
  if (const auto* connect = std::get_if<Connect>(&request)) {
    if (udp_port_) return "a second Connect";
    return Take(*connect, frame.head.command_id);
  }
  if (!udp_port_) {
    const auto asked = static_cast<HandCommandId>(frame.head.command);
    return fmt::format("{} before Connect", Name(asked));
  }
  Take(std::get<HandCommand>(request), frame.head);
  return {};
}

std::optional<std::string> HandSession::Take(const Connect& connect, std::uint32_t command_id) {
  const bool fits = connect.version == kHandVersion;
  const auto status = fits ? ConnectStatus::kSuccess : ConnectStatus::kIncompatibleLibraryVersion;
  if (fits && connect.udp_port == 0) return "Connect without a UDP port for states";
  answers_(EncodeHandConnectAnswer(command_id, status, kHandVersion));
  if (!fits) {
    return fmt::format("it speaks protocol {}; this hand speaks {}", connect.version, kHandVersion);
  }
  udp_port_ = connect.udp_port;
  return {};
}

void HandSession::Take(const HandCommand& command, const FrameHead& head) {
  const auto id = static_cast<HandCommandId>(head.command);
  const HandStart start = service_.Start(command);
  if (start.ticket == 0) {
    answers_(EncodeHandAnswer(id, head.command_id, HandResult::kFail));
    return;
  }
  pending_.push_back({start.ticket, id, head.command_id});
  OnProgress();  // answers the command that it aborted, and itself if already over
}

void HandSession::OnProgress() {
  const auto is_over = [this](const Pending& one) {
    const std::optional<HandResult> result = service_.Outcome(one.ticket);
    if (result) answers_(EncodeHandAnswer(one.command, one.command_id, *result));
    return result.has_value();
  };
  std::erase_if(pending_, is_over);
}

}  // namespace twin::fci
