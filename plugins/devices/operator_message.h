#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string_view>

#include "twin/core/realtime.h"
#include "twin/teleop/operator_sample.h"

// Datagrams between an external device program and the twin, version 1; README.md has their bytes.
// Little-endian, packed, fixed size. All received bytes are untrusted.
//
// Threads: any. Real-time: noexcept, does not allocate.
namespace twin::devices {

inline constexpr std::size_t kSampleBytes = 116;
inline constexpr std::size_t kFeedbackBytes = 72;

/// Access token of a program: 1 to 16 printable characters, padded with zeros.
using Token = std::array<char, 16>;

/// Converts a text to a token; nullopt if it is empty, too long, or not printable ASCII.
[[nodiscard]] std::optional<Token> TokenOf(std::string_view text) noexcept;

/// Largest sequence of a sample: more than thirty years at 1 kHz.
inline constexpr std::uint64_t kMostSequence = std::uint64_t{1} << 40;

struct SampleMessage {
  Token token{};
  teleop::OperatorSample sample;
};

/// @returns nullopt unless the bytes are exactly a sample: size, magic, version, kind and flag;
/// sequence in [1, kMostSequence]; axes finite and within MostOfAxis (operator_ranges.h).
[[nodiscard]] std::optional<SampleMessage> ParseSample(std::span<const std::byte> bytes) noexcept
    TWIN_REALTIME;

void WriteSample(const SampleMessage& message,
                 std::span<std::byte, kSampleBytes> to) noexcept TWIN_REALTIME;

/// @returns nullopt unless the bytes are exactly a feedback: as ParseSample; the wrench finite.
[[nodiscard]] std::optional<teleop::OperatorFeedback> ParseFeedback(
    std::span<const std::byte> bytes) noexcept TWIN_REALTIME;

void WriteFeedback(const teleop::OperatorFeedback& feedback,
                   std::span<std::byte, kFeedbackBytes> to) noexcept TWIN_REALTIME;

}  // namespace twin::devices
