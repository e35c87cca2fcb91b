#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string_view>

#include "twin/core/realtime.h"
#include "twin/teleop/operator_sample.h"

// The datagrams between a device's own program and the twin, version 1; README.md has their bytes.
// Little-endian, packed, of one size each. Nothing that comes from the wire is trusted.
//
// Threads: any. Real-time: noexcept, allocates nothing.
namespace twin::devices {

inline constexpr std::size_t kSampleBytes = 116;
inline constexpr std::size_t kFeedbackBytes = 72;

/// What a program must know to be heard: 1 to 16 printable characters, zeros behind them.
using Token = std::array<char, 16>;

/// The token that a text is. Nothing when it is empty, too long, or has other characters than
/// printable ones of ASCII.
[[nodiscard]] std::optional<Token> TokenOf(std::string_view text) noexcept;

/// The largest number of a sample: more than thirty years of a thousand a second.
inline constexpr std::uint64_t kMostSequence = std::uint64_t{1} << 40;

struct SampleMessage {
  Token token{};
  teleop::OperatorSample sample;
};

/// @returns nothing when the bytes are not exactly a sample: its size, magic, version, kind and
/// flag; its number in [1, kMostSequence]; axes finite and within MostOfAxis (operator_ranges.h).
[[nodiscard]] std::optional<SampleMessage> ParseSample(std::span<const std::byte> bytes) noexcept
    TWIN_REALTIME;

void WriteSample(const SampleMessage& message,
                 std::span<std::byte, kSampleBytes> to) noexcept TWIN_REALTIME;

/// @returns nothing when the bytes are not exactly a feedback: as ParseSample; the wrench finite.
[[nodiscard]] std::optional<teleop::OperatorFeedback> ParseFeedback(
    std::span<const std::byte> bytes) noexcept TWIN_REALTIME;

void WriteFeedback(const teleop::OperatorFeedback& feedback,
                   std::span<std::byte, kFeedbackBytes> to) noexcept TWIN_REALTIME;

}  // namespace twin::devices
