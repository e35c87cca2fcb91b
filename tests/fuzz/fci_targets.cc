#include "fuzz/fci_targets.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "twin/core/error.h"
#include "twin/fci/datagrams.h"
#include "twin/fci/frame_reader.h"
#include "twin/fci/requests.h"

namespace twin::fci::fuzz {
namespace {

/// Of a client here; small, so that a fuzzer meets the bound.
constexpr std::size_t kLargestAnswer = 1024;

std::uint8_t TakeByte(Bytes& data) {
  if (data.empty()) return 0;
  const auto first = static_cast<std::uint8_t>(data.front());
  data = data.subspan(1);
  return first;
}

/// Gives `data` to a reader in pieces of at most `piece` bytes, and each frame to `on_frame`.
template <typename OnFrame>
void ReadStream(HeadKind kind, std::size_t largest, Bytes data, std::size_t piece,
                OnFrame on_frame) {
  FrameReader reader(kind, largest);
  const std::size_t head_bytes = kind == HeadKind::kArm ? kArmHeadBytes : kHandHeadBytes;
  while (!data.empty() && reader.fault() == nullptr) {
    const auto room = reader.Room();
    TWIN_CHECK(!room.empty());
    const std::size_t count = std::min({room.size(), data.size(), piece});
    std::copy_n(data.begin(), count, room.begin());
    reader.Received(count);
    data = data.subspan(count);
    while (const auto frame = reader.Next()) {
      TWIN_CHECK(frame->head.size == head_bytes + frame->payload.size());
      TWIN_CHECK(frame->head.size <= largest);
      on_frame(*frame);
    }
  }
}

/// Whether the request may be written otherwise than it was read: modes that do not exist are.
bool IsLossy(const ArmRequest& request) {
  const Move* move = std::get_if<Move>(&request);
  return move != nullptr && (move->modes.controller == ControllerMode::kOther ||
                             move->modes.generator == MotionGeneratorMode::kIdle);
}
bool IsLossy(const HandRequest& /*request*/) {
  return false;
}

template <typename Request>
void CheckRequest(const Frame& frame, const std::variant<Request, BadFrame>& parsed) {
  if (const auto* bad = std::get_if<BadFrame>(&parsed)) {
    TWIN_CHECK(!bad->what.empty());
    return;
  }
  const Request& request = std::get<Request>(parsed);
  const auto written = EncodeRequest(frame.head.command_id, request);
  TWIN_CHECK(written.size() == frame.head.size);
  TWIN_CHECK(IsLossy(request) ||
             std::equal(frame.payload.begin(), frame.payload.end(),
                        written.end() - static_cast<std::ptrdiff_t>(frame.payload.size())));
}

/// A datagram that is refused must leave `datagram` as it was.
template <typename Encoded, typename Datagram>
void CheckDatagram(Bytes data, Datagram datagram) {
  Encoded before;
  Encode(datagram, before);
  const DatagramFault fault = Decode(data, datagram);
  Encoded after;
  Encode(datagram, after);
  TWIN_CHECK((fault == DatagramFault::kSize) == (data.size() < after.size()));
  if (fault == DatagramFault::kNone) {
    TWIN_CHECK(std::equal(after.begin(), after.end(), data.begin()));
  } else {
    TWIN_CHECK(after == before);
  }
}

/// `data` as it is, and, when it is shorter than the datagram, as the datagram's end: there lie
/// modes and flags, which a fuzzer would hardly reach.
template <typename Encoded, typename Datagram>
void CheckDatagrams(Bytes data, const Datagram& datagram) {
  CheckDatagram<Encoded>(data, datagram);
  Encoded whole{};
  if (data.size() >= whole.size()) return;
  std::copy(data.begin(), data.end(), whole.end() - static_cast<std::ptrdiff_t>(data.size()));
  CheckDatagram<Encoded>(whole, datagram);
}

}  // namespace

void ArmRequests(Bytes data) {
  const std::size_t piece = TakeByte(data) + std::size_t{1};
  ReadStream(HeadKind::kArm, kLargestArmRequest, data, piece,
             [](const Frame& frame) { CheckRequest(frame, ParseArmRequest(frame)); });
}

void HandRequests(Bytes data) {
  const std::size_t piece = TakeByte(data) + std::size_t{1};
  ReadStream(HeadKind::kHand, kLargestHandRequest, data, piece,
             [](const Frame& frame) { CheckRequest(frame, ParseHandRequest(frame)); });
}

void ArmAnswers(Bytes data) {
  const auto asked = static_cast<ArmCommand>(TakeByte(data) % kArmCommands);
  const std::size_t piece = TakeByte(data) + std::size_t{1};
  ReadStream(HeadKind::kArm, kLargestAnswer, data, piece, [asked](const Frame& frame) {
    const auto parsed = ParseArmAnswer(asked, frame);
    if (const auto* answer = std::get_if<ArmAnswer>(&parsed)) {
      TWIN_CHECK(answer->library.size() < frame.payload.size());
      const bool walls = asked == ArmCommand::kGetCartesianLimit;
      TWIN_CHECK(walls || !answer->limit.object_activation);
    } else {
      TWIN_CHECK(!std::get<BadFrame>(parsed).what.empty());
    }
  });
}

void HandAnswers(Bytes data) {
  const auto asked = static_cast<HandCommandId>(TakeByte(data) % kHandCommands);
  const std::size_t piece = TakeByte(data) + std::size_t{1};
  ReadStream(HeadKind::kHand, kLargestAnswer, data, piece, [asked](const Frame& frame) {
    const auto parsed = ParseHandAnswer(asked, frame);
    if (const auto* answer = std::get_if<HandAnswer>(&parsed)) {
      TWIN_CHECK(answer->result <= HandResult::kAborted);
    } else {
      TWIN_CHECK(!std::get<BadFrame>(parsed).what.empty());
    }
  });
}

void StateDatagram(Bytes data) {
  CheckDatagrams<StateBytes>(data, RobotState());
}

void CommandDatagram(Bytes data) {
  CheckDatagrams<CommandBytes>(data, RobotCommand());
  RobotCommand command;
  if (Decode(data, command) != DatagramFault::kNone) return;
  for (const double value : command.q_c) TWIN_CHECK(std::isfinite(value));
  for (const double value : command.O_T_EE_c) TWIN_CHECK(std::isfinite(value));
  for (const double value : command.tau_J_d) TWIN_CHECK(std::isfinite(value));
}

void HandStateDatagram(Bytes data) {
  CheckDatagrams<HandStateBytes>(data, HandState());
}

}  // namespace twin::fci::fuzz
