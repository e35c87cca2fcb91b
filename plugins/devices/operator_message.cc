#include "plugins/devices/operator_message.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "twin/teleop/operator_ranges.h"

namespace twin::devices {
namespace {

static_assert(std::endian::native == std::endian::little,
              "numbers are copied to the wire as they lie in memory");

constexpr std::array<char, 4> kSampleMagic{'P', 'T', 'O', 'S'};
constexpr std::array<char, 4> kFeedbackMagic{'P', 'T', 'O', 'F'};
constexpr std::uint16_t kVersion = 1;

/// Bits of a feedback's flags.
enum : std::uint8_t {
  kStopped = 1,
  kHolding = 2,
  kHandClosed = 4,
  kFine = 8,
  kAtBorder = 16,
  kAllFlags = 31,
};

/// Reads successive values from bytes of sufficient length.
class Taker {
 public:
  explicit Taker(std::span<const std::byte> bytes) noexcept : at_(bytes.data()) {}
  template <typename T>
  T Take() noexcept {
    T value{};
    std::memcpy(&value, at_, sizeof value);
    at_ += sizeof value;
    return value;
  }

 private:
  const std::byte* at_;
};

/// Writes successive values to bytes of sufficient length.
class Putter {
 public:
  explicit Putter(std::span<std::byte> bytes) noexcept : at_(bytes.data()) {}
  template <typename T>
  void Put(const T& value) noexcept {
    std::memcpy(at_, &value, sizeof value);
    at_ += sizeof value;
  }

 private:
  std::byte* at_;
};

bool AreWithin(const Vector6& values, double most) noexcept {
  return std::ranges::all_of(values, [most](double v) { return std::abs(v) <= most; });
}

}  // namespace

std::optional<Token> TokenOf(std::string_view text) noexcept {
  Token token{};
  if (text.empty() || text.size() > token.size()) return {};
  if (!std::ranges::all_of(text, [](char c) { return c >= 0x20 && c < 0x7F; })) return {};
  std::ranges::copy(text, token.begin());
  return token;
}

std::optional<SampleMessage> ParseSample(std::span<const std::byte> bytes) noexcept {
  if (bytes.size() != kSampleBytes) return {};
  Taker in(bytes);
  if (in.Take<std::array<char, 4>>() != kSampleMagic) return {};
  if (in.Take<std::uint16_t>() != kVersion) return {};
  SampleMessage message;
  teleop::OperatorSample& sample = message.sample;
  const auto kind = in.Take<std::uint8_t>();
  const auto engaged = in.Take<std::uint8_t>();
  if (kind > 1 || engaged > 1) return {};
  sample.kind = static_cast<teleop::AxisKind>(kind);
  sample.engaged = engaged == 1;
  message.token = in.Take<Token>();
  sample.sequence = in.Take<std::uint64_t>();
  if (sample.sequence == 0 || sample.sequence > kMostSequence) return {};
  sample.at = Time(Duration(in.Take<std::int64_t>()));
  sample.axes = in.Take<Vector6>();
  if (!AreWithin(sample.axes, teleop::MostOfAxis(sample.kind))) return {};
  for (const auto presses : teleop::kPresses) sample.*presses = in.Take<std::uint32_t>();
  return message;
}

void WriteSample(const SampleMessage& message, std::span<std::byte, kSampleBytes> to) noexcept {
  const teleop::OperatorSample& sample = message.sample;
  Putter out(to);
  out.Put(kSampleMagic);
  out.Put(kVersion);
  out.Put(static_cast<std::uint8_t>(sample.kind));
  out.Put(static_cast<std::uint8_t>(sample.engaged));
  out.Put(message.token);
  out.Put(sample.sequence);
  out.Put(static_cast<std::int64_t>(sample.at.time_since_epoch().count()));
  out.Put(sample.axes);
  for (const auto presses : teleop::kPresses) out.Put(sample.*presses);
}

std::optional<teleop::OperatorFeedback> ParseFeedback(std::span<const std::byte> bytes) noexcept {
  if (bytes.size() != kFeedbackBytes) return {};
  Taker in(bytes);
  if (in.Take<std::array<char, 4>>() != kFeedbackMagic) return {};
  if (in.Take<std::uint16_t>() != kVersion) return {};
  const auto mode = in.Take<std::uint8_t>();
  const auto flags = in.Take<std::uint8_t>();
  if (mode > 1 || flags > kAllFlags) return {};
  teleop::OperatorFeedback feedback;
  feedback.mode = static_cast<teleop::Mode>(mode);
  feedback.stopped = (flags & kStopped) != 0;
  feedback.holding = (flags & kHolding) != 0;
  feedback.hand_closed = (flags & kHandClosed) != 0;
  feedback.fine = (flags & kFine) != 0;
  feedback.at_border = (flags & kAtBorder) != 0;
  feedback.sequence = in.Take<std::uint64_t>();
  feedback.echo = in.Take<std::uint64_t>();
  feedback.wrench = in.Take<Vector6>();
  const bool is_finite =
      std::ranges::all_of(feedback.wrench, [](double w) { return std::isfinite(w); });
  if (!is_finite) return {};
  return feedback;
}

void WriteFeedback(const teleop::OperatorFeedback& feedback,
                   std::span<std::byte, kFeedbackBytes> to) noexcept {
  std::uint8_t flags = 0;
  if (feedback.stopped) flags |= kStopped;
  if (feedback.holding) flags |= kHolding;
  if (feedback.hand_closed) flags |= kHandClosed;
  if (feedback.fine) flags |= kFine;
  if (feedback.at_border) flags |= kAtBorder;
  Putter out(to);
  out.Put(kFeedbackMagic);
  out.Put(kVersion);
  out.Put(static_cast<std::uint8_t>(feedback.mode));
  out.Put(flags);
  out.Put(feedback.sequence);
  out.Put(feedback.echo);
  out.Put(feedback.wrench);
}

}  // namespace twin::devices
