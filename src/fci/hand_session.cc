#include "twin/fci/hand_session.h"

#include <algorithm>
#include <utility>
#include <variant>

#include <fmt/format.h>

namespace twin::fci {

HandSession::HandSession(HandService& service, Answers answers, HandDevice device)
    : service_(service), answers_(std::move(answers)), device_(device) {}

std::optional<std::string> HandSession::OnFrame(const Frame& frame) {
  const std::variant<HandRequest, BadFrame> parsed =
      device_ == HandDevice::kCobotPump ? ParseVacuumRequest(frame) : ParseHandRequest(frame);
  if (const auto* bad = std::get_if<BadFrame>(&parsed)) return bad->what;
  const auto& request = std::get<HandRequest>(parsed);
  if (const auto* connect = std::get_if<Connect>(&request)) {
    if (udp_port_) return "a second Connect";
    return Take(*connect, frame.head.command_id);
  }
  const auto& command = std::get<HandCommand>(request);
  if (!udp_port_) return fmt::format("{} before Connect", twin::Name(command));
  Take(command, frame.head);
  return {};
}

std::optional<std::string> HandSession::Take(const Connect& connect, std::uint32_t command_id) {
  const std::uint16_t version = VersionOf(device_);
  const bool fits = connect.version == version;
  const auto status = fits ? ConnectStatus::kSuccess : ConnectStatus::kIncompatibleLibraryVersion;
  if (fits && connect.udp_port == 0) return "Connect without a UDP port for states";
  answers_(EncodeHandConnectAnswer(command_id, status, version));
  if (!fits) {
    return fmt::format("it speaks protocol {}; this hand speaks {}", connect.version, version);
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
