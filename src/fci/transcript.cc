#include "twin/fci/transcript.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string_view>
#include <utility>
#include <variant>

#include <fmt/format.h>

#include "twin/fci/datagrams.h"
#include "twin/fci/frame_reader.h"
#include "twin/fci/sockets.h"

namespace twin::fci {
namespace {

/// Upper bounds of streams and of unanswered requests; beyond them the record starts anew.
constexpr std::size_t kMostStreams = 16;
constexpr std::size_t kMostRequests = 1024;
/// Largest stored answer, bytes: several times the largest known model library.
constexpr std::size_t kLargestAnswer = std::size_t{4} << 20;

using Ends = std::pair<record::PacketEnd, record::PacketEnd>;

std::string HeadOf(const record::Packet& packet) {
  const auto ns = packet.at.time_since_epoch().count();
  return fmt::format("{}.{:09} s  {} > {}  ", ns / 1'000'000'000, ns % 1'000'000'000,
                     ToString(packet.from), ToString(packet.to));
}

std::string SummaryOf(const RobotState& state) {
  return fmt::format("state {}: {}, {}, {}", state.message_id, Name(state.robot_mode),
                     Name(state.motion_generator_mode), Name(state.controller_mode));
}

std::string SummaryOf(const RobotCommand& command) {
  return fmt::format("command for state {}{}", command.message_id,
                     command.motion_generation_finished ? ": finished" : "");
}

std::string SummaryOf(const HandState& state) {
  return fmt::format("hand state {}: {} m{}", state.message_id, state.width,
                     state.is_grasped ? ", holds an object" : "");
}

}  // namespace

class Transcript::Impl {
 public:
  explicit Impl(const TranscriptOptions& options) : options_(options) {}

  [[nodiscard]] std::uint64_t elsewhere() const { return elsewhere_; }

  std::string Take(const record::Packet& packet) {
    if (packet.transport == record::Transport::kUdp) return TakeDatagram(packet);
    return TakeStream(packet);
  }

 private:
  /// One direction of a connection.
  struct Stream {
    FrameReader frames;
    bool ended = false;
  };

  std::string TakeDatagram(const record::Packet& packet) const {
    switch (packet.bytes.size()) {
      case kStateBytes: return DatagramText<RobotState>(packet);
      case kCommandBytes: return DatagramText<RobotCommand>(packet);
      case kHandStateBytes: return DatagramText<HandState>(packet);
      default:
        return HeadOf(packet) +
               fmt::format("datagram of {} bytes: none of the protocol\n", packet.bytes.size());
    }
  }

  template <typename Message>
  std::string DatagramText(const record::Packet& packet) const {
    Message message;
    const DatagramFault fault = Decode(packet.bytes, message);
    if (fault == DatagramFault::kNone) return Text(packet, SummaryOf(message), message);
    return HeadOf(packet) +
           fmt::format("datagram of {} bytes, damaged: {}\n", packet.bytes.size(), Name(fault));
  }

  template <typename... Message>
  std::string Text(const record::Packet& packet, std::string_view summary,
                   const Message&... message) const {
    std::string text = HeadOf(packet).append(summary).append("\n");
    if (options_.fields) text += FieldsOf(message...);
    return text;
  }

  [[nodiscard]] bool IsPort(std::uint16_t port) const {
    return port == options_.arm_port || port == options_.hand_port;
  }

  std::string TakeStream(const record::Packet& packet) {
    const bool is_request = IsPort(packet.to.port);
    if (!is_request && !IsPort(packet.from.port)) {
      ++elsewhere_;
      return HeadOf(packet) +
             fmt::format("{} bytes of TCP between other ports\n", packet.bytes.size());
    }
    const std::uint16_t service = is_request ? packet.to.port : packet.from.port;
    const HeadKind kind = service == options_.arm_port ? HeadKind::kArm : HeadKind::kHand;
    if (streams_.size() == kMostStreams) streams_.clear();
    auto [it, is_new] = streams_.try_emplace(
        Ends{packet.from, packet.to},
        Stream{FrameReader(kind, is_request ? kLargestArmRequest : kLargestAnswer)});
    return Feed(packet, kind, is_request, it->second);
  }

  std::string Feed(const record::Packet& packet, HeadKind kind, bool is_request, Stream& stream) {
    std::string text;
    std::span<const std::byte> left = packet.bytes;
    while (!stream.ended) {
      while (const auto frame = stream.frames.Next()) {
        text += is_request ? RequestText(packet, kind, *frame) : AnswerText(packet, kind, *frame);
      }
      if (const std::string* fault = stream.frames.fault()) {
        stream.ended = true;
        text += HeadOf(packet) + fmt::format("TCP stream is none of the protocol: {}\n", *fault);
      }
      if (left.empty() || stream.ended) break;
      const std::span<std::byte> room = stream.frames.Room();
      const std::size_t count = std::min(room.size(), left.size());
      std::ranges::copy(left.first(count), room.begin());
      stream.frames.Received(count);
      left = left.subspan(count);
    }
    return text;
  }

  template <typename Request, typename Id>
  std::string RequestTextOf(const record::Packet& packet, const Frame& frame,
                            const std::variant<Request, BadFrame>& parsed) {
    if (const auto* bad = std::get_if<BadFrame>(&parsed)) {
      return HeadOf(packet) +
             fmt::format("request {}, damaged: {}\n", frame.head.command_id, bad->what);
    }
    if (asked_.size() == kMostRequests) asked_.clear();
    asked_[{Ends{packet.to, packet.from}, frame.head.command_id}] = frame.head.command;
    return Text(packet,
                fmt::format("request {}: {}", frame.head.command_id,
                            Name(static_cast<Id>(frame.head.command))),
                std::get<Request>(parsed));
  }

  std::string RequestText(const record::Packet& packet, HeadKind kind, const Frame& frame) {
    return kind == HeadKind::kArm
               ? RequestTextOf<ArmRequest, ArmCommand>(packet, frame, ParseArmRequest(frame))
               : RequestTextOf<HandRequest, HandCommandId>(packet, frame, ParseHandRequest(frame));
  }

  template <typename Id, typename Answer>
  std::string AnswerTextOf(const record::Packet& packet, const Frame& frame, Id asked,
                           const std::variant<Answer, BadFrame>& parsed) const {
    if (const auto* bad = std::get_if<BadFrame>(&parsed)) {
      return HeadOf(packet) +
             fmt::format("answer {}, damaged: {}\n", frame.head.command_id, bad->what);
    }
    return Text(packet, fmt::format("answer {}: {}", frame.head.command_id, Name(asked)), asked,
                std::get<Answer>(parsed));
  }

  std::string AnswerText(const record::Packet& packet, HeadKind kind, const Frame& frame) const {
    const auto asked = asked_.find({Ends{packet.from, packet.to}, frame.head.command_id});
    if (asked == asked_.end()) {
      return HeadOf(packet) +
             fmt::format("answer {}: its request was not captured\n", frame.head.command_id);
    }
    if (kind == HeadKind::kArm) {
      const auto command = static_cast<ArmCommand>(asked->second);
      return AnswerTextOf(packet, frame, command, ParseArmAnswer(command, frame));
    }
    const auto command = static_cast<HandCommandId>(asked->second);
    return AnswerTextOf(packet, frame, command, ParseHandAnswer(command, frame));
  }

  TranscriptOptions options_;
  std::uint64_t elsewhere_ = 0;
  std::map<Ends, Stream> streams_;
  /// Command of each request, by its answer's endpoints and its id.
  std::map<std::pair<Ends, std::uint32_t>, std::uint32_t> asked_;
};

Transcript::Transcript(const TranscriptOptions& options) : impl_(std::make_unique<Impl>(options)) {}
Transcript::~Transcript() = default;

std::string Transcript::Take(const record::Packet& packet) {
  return impl_->Take(packet);
}

std::uint64_t Transcript::elsewhere() const noexcept {
  return impl_->elsewhere();
}

}  // namespace twin::fci
