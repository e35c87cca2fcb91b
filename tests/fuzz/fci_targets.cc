#include "fuzz/fci_targets.h"

#include <algorithm>
#include <array>
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

constexpr std::array kProtocols{Protocol::k5, Protocol::k10};

/// @param encode  writes a frame of an id and a request.
template <typename Request, typename Encode>
void CheckRequest(const Frame& frame, const std::variant<Request, BadFrame>& parsed,
                  const Encode& encode) {
  if (const auto* bad = std::get_if<BadFrame>(&parsed)) {
    TWIN_CHECK(!bad->what.empty());
    return;
  }
  const Request& request = std::get<Request>(parsed);
  const auto written = encode(frame.head.command_id, request);
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

/// A datagram of protocol 10: what is taken, is written and taken again as it was. Bits of a NaN
/// may differ, and so may which of two flags ends a motion.
template <typename Buffer, typename Datagram>
void CheckDatagram10(Bytes data, Datagram datagram) {
  Buffer before{};
  static_cast<void>(Encode(Protocol::k10, datagram, before));
  const DatagramFault fault = Decode(Protocol::k10, data, datagram);
  Buffer after{};
  const auto written = Encode(Protocol::k10, datagram, after);
  TWIN_CHECK((fault == DatagramFault::kSize) == (data.size() < written.size()));
  if (fault != DatagramFault::kNone) {
    TWIN_CHECK(after == before);
    return;
  }
  TWIN_CHECK(Decode(Protocol::k10, written, datagram) == DatagramFault::kNone);
  Buffer again{};
  static_cast<void>(Encode(Protocol::k10, datagram, again));
  TWIN_CHECK(again == after);
}

}  // namespace

void ArmRequests(Bytes data) {
  const std::size_t piece = TakeByte(data) + std::size_t{1};
  for (const Protocol protocol : kProtocols) {
    ReadStream(HeadKind::kArm, kLargestArmRequest, data, piece, [protocol](const Frame& frame) {
      CheckRequest(frame, ParseArmRequest(frame, protocol),
                   [protocol](std::uint32_t id, const ArmRequest& request) {
                     return EncodeRequest(id, request, protocol);
                   });
    });
  }
}

void HandRequests(Bytes data) {
  const std::size_t piece = TakeByte(data) + std::size_t{1};
  ReadStream(HeadKind::kHand, kLargestHandRequest, data, piece, [](const Frame& frame) {
    CheckRequest(frame, ParseHandRequest(frame), [](std::uint32_t id, const HandRequest& request) {
      return EncodeRequest(id, request);
    });
  });
}

void VacuumRequests(Bytes data) {
  const std::size_t piece = TakeByte(data) + std::size_t{1};
  ReadStream(HeadKind::kHand, kLargestHandRequest, data, piece, [](const Frame& frame) {
    CheckRequest(frame, ParseVacuumRequest(frame), &EncodeVacuumRequest);
  });
}

void ArmAnswers(Bytes data) {
  const std::uint8_t first = TakeByte(data);
  const auto asked = static_cast<ArmCommand>(first % kArmCommands);
  const Protocol protocol = kProtocols[first / 128];
  const std::size_t piece = TakeByte(data) + std::size_t{1};
  ReadStream(HeadKind::kArm, kLargestAnswer, data, piece, [=](const Frame& frame) {
    const auto parsed = ParseArmAnswer(asked, frame, protocol);
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
  CheckDatagram10<StateBytes>(data, RobotState());
}

void CommandDatagram(Bytes data) {
  CheckDatagrams<CommandBytes>(data, RobotCommand());
  CheckDatagram10<AnyCommandBytes>(data, RobotCommand());
  RobotCommand command;
  if (Decode(data, command) != DatagramFault::kNone) return;
  for (const double value : command.q_c) TWIN_CHECK(std::isfinite(value));
  for (const double value : command.O_T_EE_c) TWIN_CHECK(std::isfinite(value));
  for (const double value : command.tau_J_d) TWIN_CHECK(std::isfinite(value));
}

void HandStateDatagram(Bytes data) {
  CheckDatagrams<HandStateBytes>(data, HandState());
}

void VacuumStateDatagram(Bytes data) {
  CheckDatagrams<VacuumStateBytes>(data, VacuumState());
}

}  // namespace twin::fci::fuzz
