#include "twin/fci/transcript.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
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

std::string SummaryOf(const VacuumState& state) {
  return fmt::format("vacuum state {}: {} mbar{}", state.message_id, state.vacuum,
                     state.part_present ? ", holds an object" : "");
}

/// Whose port a stream has.
enum class Service : std::uint8_t { kArm, kHand, kVacuum };

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
      case kStateBytes: return StateText(packet, Protocol::k5);
      case kState10Bytes: return StateText(packet, Protocol::k10);
      case kCommandBytes: return CommandText(packet, Protocol::k5);
      case kCommand10Bytes: return CommandText(packet, Protocol::k10);
      case kHandStateBytes: return ToolText<HandState>(packet);
      case kVacuumStateBytes: return ToolText<VacuumState>(packet);
      default:
        return HeadOf(packet) +
               fmt::format("datagram of {} bytes: none of the protocol\n", packet.bytes.size());
    }
  }

  std::string StateText(const record::Packet& packet, Protocol protocol) const {
    RobotState state;
    const DatagramFault fault = Decode(protocol, packet.bytes, state);
    return DatagramText(packet, fault, state, protocol);
  }
  std::string CommandText(const record::Packet& packet, Protocol protocol) const {
    RobotCommand command;
    const DatagramFault fault = Decode(protocol, packet.bytes, command);
    return DatagramText(packet, fault, command);
  }

  /// Of the hand or the vacuum gripper.
  template <typename State>
  std::string ToolText(const record::Packet& packet) const {
    State state;
    const DatagramFault fault = Decode(packet.bytes, state);
    return DatagramText(packet, fault, state);
  }

  template <typename Message, typename... Rest>
  std::string DatagramText(const record::Packet& packet, DatagramFault fault,
                           const Message& message, const Rest&... rest) const {
    if (fault == DatagramFault::kNone) return Text(packet, SummaryOf(message), message, rest...);
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

  [[nodiscard]] std::optional<Service> ServiceAt(std::uint16_t port) const {
    if (port == options_.arm_port) return Service::kArm;
    if (port == options_.hand_port) return Service::kHand;
    if (port == options_.vacuum_port) return Service::kVacuum;
    return {};
  }

  std::string TakeStream(const record::Packet& packet) {
    const auto asked = ServiceAt(packet.to.port);
    const bool is_request = asked.has_value();
    const auto service = is_request ? asked : ServiceAt(packet.from.port);
    if (!service) {
      ++elsewhere_;
      return HeadOf(packet) +
             fmt::format("{} bytes of TCP between other ports\n", packet.bytes.size());
    }
    const HeadKind kind = *service == Service::kArm ? HeadKind::kArm : HeadKind::kHand;
    if (streams_.size() == kMostStreams) streams_.clear();
    auto [it, is_new] = streams_.try_emplace(
        Ends{packet.from, packet.to},
        Stream{FrameReader(kind, is_request ? kLargestArmRequest : kLargestAnswer)});
    return Feed(packet, *service, is_request, it->second);
  }

  std::string Feed(const record::Packet& packet, Service service, bool is_request, Stream& stream) {
    std::string text;
    std::span<const std::byte> left = packet.bytes;
    while (!stream.ended) {
      while (const auto frame = stream.frames.Next()) {
        text +=
            is_request ? RequestText(packet, service, *frame) : AnswerText(packet, service, *frame);
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

  template <typename Request, typename... Rest>
  std::string RequestTextOf(const record::Packet& packet, const Frame& frame,
                            const std::variant<Request, BadFrame>& parsed, std::string_view name,
                            const Rest&... rest) {
    if (const auto* bad = std::get_if<BadFrame>(&parsed)) {
      return HeadOf(packet) +
             fmt::format("request {}, damaged: {}\n", frame.head.command_id, bad->what);
    }
    if (asked_.size() == kMostRequests) asked_.clear();
    asked_[{Ends{packet.to, packet.from}, frame.head.command_id}] = frame.head.command;
    return Text(packet, fmt::format("request {}: {}", frame.head.command_id, name),
                std::get<Request>(parsed), rest...);
  }

  std::string RequestText(const record::Packet& packet, Service service, const Frame& frame) {
    if (service == Service::kVacuum) {
      return RequestTextOf(packet, frame, ParseVacuumRequest(frame),
                           Name(static_cast<VacuumCommandId>(frame.head.command)));
    }
    if (service == Service::kHand) {
      return RequestTextOf(packet, frame, ParseHandRequest(frame),
                           Name(static_cast<HandCommandId>(frame.head.command)));
    }
    const Ends client{packet.from, packet.to};
    // Connect is the same in both protocols, and says which it is.
    if (const auto first = ParseArmRequest(frame);
        const auto* request = std::get_if<ArmRequest>(&first)) {
      if (const auto* connect = std::get_if<Connect>(request)) {
        if (speak10_.size() == kMostStreams) speak10_.clear();
        connect->version == VersionOf(Protocol::k10) ? static_cast<void>(speak10_.insert(client))
                                                     : static_cast<void>(speak10_.erase(client));
      }
    }
    const Protocol protocol = ProtocolOf(client);
    const std::optional<ArmCommand> command = ArmCommandAt(protocol, frame.head.command);
    return RequestTextOf(packet, frame, ParseArmRequest(frame, protocol),
                         command ? Name(*command) : "unknown", protocol);
  }

  /// @param client  the direction of requests.
  [[nodiscard]] Protocol ProtocolOf(const Ends& client) const {
    return speak10_.contains(client) ? Protocol::k10 : Protocol::k5;
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

  std::string AnswerText(const record::Packet& packet, Service service, const Frame& frame) const {
    const auto asked = asked_.find({Ends{packet.from, packet.to}, frame.head.command_id});
    if (asked == asked_.end()) {
      return HeadOf(packet) +
             fmt::format("answer {}: its request was not captured\n", frame.head.command_id);
    }
    if (service == Service::kArm) {
      const Protocol protocol = ProtocolOf({packet.to, packet.from});
      const ArmCommand command =
          ArmCommandAt(protocol, asked->second).value_or(ArmCommand::kConnect);
      return AnswerTextOf(packet, frame, command, ParseArmAnswer(command, frame, protocol));
    }
    if (service == Service::kHand) {
      const auto command = static_cast<HandCommandId>(asked->second);
      return AnswerTextOf(packet, frame, command, ParseHandAnswer(command, frame));
    }
    const auto command = static_cast<VacuumCommandId>(asked->second);
    return AnswerTextOf(packet, frame, command, ParseHandAnswer(command, frame));
  }

  TranscriptOptions options_;
  std::uint64_t elsewhere_ = 0;
  std::map<Ends, Stream> streams_;
  std::set<Ends> speak10_;  ///< directions of requests in protocol 10
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
