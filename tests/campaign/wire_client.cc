#include "campaign/wire_client.h"

#include <poll.h>

#include <algorithm>
#include <array>
#include <variant>

#include <fmt/format.h>

#include "conformance/reference_rules.h"
#include "twin/fci/datagrams.h"

namespace twin::campaign {
namespace {

constexpr Duration kPatience = std::chrono::seconds(20);
constexpr std::uint32_t kLoopback = 0x7f000001;

}  // namespace

WireClient::WireClient(const fci::Endpoint& arm, fci::Protocol protocol)
    : protocol_(protocol),
      udp_(clock_, {kLoopback, 0}),
      tcp_(fci::TcpStream::Connect(arm, kPatience)),
      reader_(fci::HeadKind::kArm, fci::kLargestModelLibrary) {}

std::uint32_t WireClient::Frame(const fci::ArmRequest& request, std::vector<std::byte>& bytes) {
  const std::uint32_t id = ++last_command_id_;
  const std::vector<std::byte> frame = fci::EncodeRequest(id, request, protocol_);
  bytes.insert(bytes.end(), frame.begin(), frame.end());
  owed_[id] = fci::CommandOf(request);
  return id;
}

void WireClient::Send(std::span<const std::byte> bytes, std::span<const std::size_t> cuts) {
  std::size_t begin = 0;
  const auto send_to = [&](std::size_t end) {
    while (begin < end) {
      std::size_t sent = 0;
      const fci::StreamResult result = tcp_.Send(bytes.subspan(begin, end - begin), sent);
      if (result == fci::StreamResult::kClosed || result == fci::StreamResult::kReset) return;
      begin += sent;
    }
  };
  for (const std::size_t cut : cuts) send_to(std::min(cut, bytes.size()));
  send_to(bytes.size());
}

std::uint8_t WireClient::Ask(const fci::ArmRequest& request) {
  std::vector<std::byte> bytes;
  const std::uint32_t id = Frame(request, bytes);
  Send(bytes);
  return AwaitAnswer(id);
}

bool WireClient::Wait(int fd, Time deadline) {
  std::array<pollfd, 1> waited{{{fd, POLLIN, 0}}};
  return fci::AwaitAny(waited, clock_, deadline);
}

bool WireClient::Take() {
  std::size_t received = 0;
  const fci::StreamResult result = tcp_.Receive(reader_.Room(), received);
  is_closed_ =
      is_closed_ || result == fci::StreamResult::kClosed || result == fci::StreamResult::kReset;
  reader_.Received(received);
  bool took = false;
  for (auto frame = reader_.Next(); frame; frame = reader_.Next()) {
    took = true;
    const std::uint32_t id = frame->head.command_id;
    const auto owed = owed_.find(id);
    if (owed == owed_.end()) {
      throw BrokenPromise(fmt::format("an answer to request {} that none is owed to", id));
    }
    if (frame->head.command != fci::NumberOf(protocol_, owed->second)) {
      throw BrokenPromise(fmt::format("request {} is {}, its answer is to {}", id,
                                      Name(owed->second), frame->head.command));
    }
    const auto parsed = fci::ParseArmAnswer(owed->second, *frame, protocol_);
    if (const auto* bad = std::get_if<fci::BadFrame>(&parsed)) throw BrokenPromise(bad->what);
    kept_.emplace(id, std::get<fci::ArmAnswer>(parsed).status);
    answered_.push_back(id);
    owed_.erase(owed);
  }
  if (const std::string* fault = reader_.fault()) throw BrokenPromise(*fault);
  return took;
}

std::uint8_t WireClient::AwaitAnswer(std::uint32_t command_id) {
  const Time deadline = clock_.Now() + kPatience;
  while (true) {
    if (const auto found = kept_.find(command_id); found != kept_.end()) {
      const std::uint8_t status = found->second;
      kept_.erase(found);
      return status;
    }
    if (Take()) continue;
    const auto owed = owed_.find(command_id);
    const std::string_view what = owed != owed_.end() ? Name(owed->second) : "a request";
    if (is_closed_) throw BrokenPromise(fmt::format("the connection was ended before {}", what));
    if (!Wait(tcp_.fd(), deadline)) throw BrokenPromise(fmt::format("no answer to {}", what));
  }
}

void WireClient::AwaitClosed() {
  const Time deadline = clock_.Now() + kPatience;
  while (!is_closed_) {
    if (Take()) continue;
    if (!is_closed_ && !Wait(tcp_.fd(), deadline)) {
      throw BrokenPromise("the connection was not ended");
    }
  }
}

std::optional<RobotState> WireClient::AwaitState(std::uint64_t above, Duration longest) {
  const Time deadline = clock_.Now() + longest;
  std::array<std::byte, fci::kStateBytes + 1> buffer{};  // protocol 5 has the longer ones
  std::optional<RobotState> newest;
  while (true) {
    while (const auto datagram = udp_.Receive(buffer)) {
      RobotState state;
      if (datagram->bytes.size() != fci::StateBytesOf(protocol_)) {
        throw BrokenPromise(fmt::format("a state of {} bytes", datagram->bytes.size()));
      }
      if (fci::Decode(protocol_, datagram->bytes, state) != fci::DatagramFault::kNone) {
        throw BrokenPromise("a state that cannot be read");
      }
      if (const auto bad = test::FindNotFinite(state)) throw BrokenPromise(*bad);
      // One sent again because it was not answered has the id that it had.
      if (state.message_id < last_id_) {
        throw BrokenPromise(fmt::format("state {} after {}", state.message_id, last_id_));
      }
      last_id_ = state.message_id;
      robot_ = datagram->from;
      if (state.message_id > above) newest = state;
    }
    if (newest) return newest;
    if (!udp_.AwaitUntil(deadline)) return std::nullopt;
  }
}

void WireClient::SendDatagram(std::span<const std::byte> bytes) {
  if (robot_) static_cast<void>(udp_.Send(bytes, *robot_));
}

void WireClient::Command(const RobotCommand& command) {
  fci::AnyCommandBytes bytes{};
  SendDatagram(fci::Encode(protocol_, command, bytes));
}

}  // namespace twin::campaign
