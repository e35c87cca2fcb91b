#include <algorithm>
#include <array>
#include <utility>

#include <fmt/format.h>

#include "fci/frame_bytes.h"
#include "fci/message_fields.h"
#include "twin/fci/requests.h"

namespace twin::fci {
namespace {

constexpr std::size_t kArmStatusBytes = 1;
constexpr std::size_t kHandStatusBytes = 2;
constexpr std::size_t kVersionBytes = 2;

static_assert(static_cast<int>(HandResult::kSuccess) == 0 &&
                  static_cast<int>(HandResult::kFail) == 1 &&
                  static_cast<int>(HandResult::kUnsuccessful) == 2 &&
                  static_cast<int>(HandResult::kAborted) == 3,
              "the hand's results have the numbers of the wire");

/// Smallest size of an answer; clients accept and ignore surplus bytes.
std::size_t LeastBytes(ArmCommand asked) noexcept {
  if (asked == ArmCommand::kConnect) return kArmStatusBytes + kVersionBytes;
  if (asked == ArmCommand::kGetCartesianLimit) {
    return kArmStatusBytes + wire::kPayload<CartesianLimit>;
  }
  return kArmStatusBytes;
}

/// @returns an error if the frame has fewer than `least` bytes.
std::optional<BadFrame> FindMissing(std::string_view name, const Frame& frame, std::size_t least) {
  if (frame.payload.size() >= least) return {};
  return BadFrame{fmt::format("{}: an answer with {} bytes of payload, {} are needed", name,
                              frame.payload.size(), least)};
}

/// @returns the result for the hand's `status`; nullopt for an unknown status.
std::optional<HandResult> ResultOf(bool is_connect, std::uint16_t status) noexcept {
  const HandResult last = is_connect ? HandResult::kFail : HandResult::kAborted;
  if (status > static_cast<std::uint16_t>(last)) return {};
  return static_cast<HandResult>(status);
}

/// Number in protocol 10 of each status of protocol 5. Statuses for activated safety functions,
/// which this program never sends, take the numbers between.
constexpr std::array<std::uint8_t, 10> kMove10{0, 1, 2, 5, 6, 7, 8, 9, 10, 11};
constexpr std::array<std::uint8_t, 5> kStop10{0, 1, 3, 4, 5};
constexpr std::array<std::uint8_t, 6> kRecovery10{0, 1, 3, 4, 5, 6};

/// Empty when both protocols have the same numbers.
std::span<const std::uint8_t> Numbers10(ArmCommand command) noexcept {
  switch (command) {
    case ArmCommand::kMove: return kMove10;
    case ArmCommand::kStopMove: return kStop10;
    case ArmCommand::kAutomaticErrorRecovery: return kRecovery10;
    default: return {};
  }
}

/// Number of the command in the protocol. @pre it has one.
std::uint32_t Number(Protocol protocol, ArmCommand command) {
  return NumberOf(protocol, command).value();
}

/// @param Id  HandCommandId or VacuumCommandId, whose answers are alike.
template <typename Id>
std::variant<HandAnswer, BadFrame> ParseAnswer(Id asked, const Frame& frame) {
  const bool is_connect = asked == Id::kConnect;
  const std::size_t least = kHandStatusBytes + (is_connect ? kVersionBytes : 0);
  if (auto bad = FindMissing(Name(asked), frame, least)) return *std::move(bad);
  std::uint16_t status = 0;
  wire::Take(frame.payload.data(), status);
  const auto result = ResultOf(is_connect, status);
  if (!result) {
    return BadFrame{
        fmt::format("{}: an answer with status {}, which does not exist", Name(asked), status)};
  }
  HandAnswer answer{*result, 0};
  if (is_connect) wire::Take(frame.payload.data() + kHandStatusBytes, answer.version);
  return answer;
}

}  // namespace

std::uint8_t StatusNumber(Protocol protocol, ArmCommand command, std::uint8_t status) noexcept {
  const std::span<const std::uint8_t> numbers = Numbers10(command);
  return protocol == Protocol::k10 && status < numbers.size() ? numbers[status] : status;
}

std::uint8_t TakeStatus(Protocol protocol, ArmCommand command, std::uint8_t number) noexcept {
  const std::span<const std::uint8_t> numbers = Numbers10(command);
  if (protocol == Protocol::k5 || numbers.empty()) return number;
  // A safety function's status stands before the one with which people deal alike.
  for (std::size_t status = 0; status < numbers.size(); ++status) {
    if (numbers[status] >= number) return static_cast<std::uint8_t>(status);
  }
  return static_cast<std::uint8_t>(numbers.size());
}

std::vector<std::byte> EncodeArmAnswer(ArmCommand command, std::uint32_t command_id,
                                       std::uint8_t status, Protocol protocol) {
  NewFrame frame(Number(protocol, command), command_id, kArmStatusBytes);
  wire::Put(frame.payload(), StatusNumber(protocol, command, status));
  return std::move(frame).Release();
}

std::vector<std::byte> EncodeArmConnectAnswer(std::uint32_t command_id, ConnectStatus status,
                                              std::uint16_t version) {
  NewFrame frame(Number(Protocol::k5, ArmCommand::kConnect), command_id,
                 kArmStatusBytes + kVersionBytes);
  wire::Put(frame.payload(), status);
  wire::Put(frame.payload() + kArmStatusBytes, version);
  return std::move(frame).Release();
}

std::vector<std::byte> EncodeCartesianLimitAnswer(std::uint32_t command_id, SetterStatus status,
                                                  const CartesianLimit& limit) {
  NewFrame frame(Number(Protocol::k5, ArmCommand::kGetCartesianLimit), command_id,
                 kArmStatusBytes + wire::kPayload<CartesianLimit>);
  wire::Put(frame.payload(), status);
  wire::PutFields(frame.payload() + kArmStatusBytes, limit);
  return std::move(frame).Release();
}

std::vector<std::byte> EncodeModelLibraryAnswer(std::uint32_t command_id, ModelLibraryStatus status,
                                                std::span<const std::byte> library) {
  NewFrame frame(Number(Protocol::k5, ArmCommand::kLoadModelLibrary), command_id,
                 kArmStatusBytes + library.size());
  wire::Put(frame.payload(), status);
  std::copy(library.begin(), library.end(), frame.payload() + kArmStatusBytes);
  return std::move(frame).Release();
}

std::vector<std::byte> EncodeRobotModelAnswer(std::uint32_t command_id, std::string_view urdf) {
  NewFrame frame(Number(Protocol::k10, ArmCommand::kGetRobotModel), command_id,
                 kArmStatusBytes + urdf.size());
  wire::Put(frame.payload(), ModelLibraryStatus::kSuccess);
  std::ranges::copy(std::as_bytes(std::span(urdf)), frame.payload() + kArmStatusBytes);
  return std::move(frame).Release();
}

std::vector<std::byte> EncodeHandAnswer(HandCommandId command, std::uint32_t command_id,
                                        HandResult result) {
  NewFrame frame(command, command_id, kHandStatusBytes);
  wire::Put(frame.payload(), static_cast<std::uint16_t>(result));
  return std::move(frame).Release();
}

std::vector<std::byte> EncodeHandConnectAnswer(std::uint32_t command_id, ConnectStatus status,
                                               std::uint16_t version) {
  NewFrame frame(HandCommandId::kConnect, command_id, kHandStatusBytes + kVersionBytes);
  wire::Put(frame.payload(), static_cast<std::uint16_t>(status));
  wire::Put(frame.payload() + kHandStatusBytes, version);
  return std::move(frame).Release();
}

std::variant<ArmAnswer, BadFrame> ParseArmAnswer(ArmCommand asked, const Frame& frame,
                                                 Protocol protocol) {
  if (auto bad = FindMissing(Name(asked), frame, LeastBytes(asked))) return *std::move(bad);
  ArmAnswer answer;
  wire::Take(frame.payload.data(), answer.status);
  answer.status = TakeStatus(protocol, asked, answer.status);
  const auto rest = frame.payload.subspan(kArmStatusBytes);
  if (asked == ArmCommand::kConnect) {
    wire::Take(rest.data(), answer.version);
  } else if (asked == ArmCommand::kGetCartesianLimit) {
    if (!wire::TakeFields(rest.data(), answer.limit)) return wire::BadFlag(Name(asked));
  } else if (asked == ArmCommand::kLoadModelLibrary || asked == ArmCommand::kGetRobotModel) {
    answer.library = rest;
  }
  return answer;
}

std::variant<HandAnswer, BadFrame> ParseHandAnswer(HandCommandId asked, const Frame& frame) {
  return ParseAnswer(asked, frame);
}

std::variant<HandAnswer, BadFrame> ParseHandAnswer(VacuumCommandId asked, const Frame& frame) {
  return ParseAnswer(asked, frame);
}

}  // namespace twin::fci
