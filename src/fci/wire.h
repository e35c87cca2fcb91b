#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <type_traits>

#include "twin/core/modes.h"
#include "twin/core/robot_errors.h"

// Single values on the wire: packed, little-endian; a flag is one byte, 0 or 1. Values are copied,
// because memory and wire have the same layout, except for a set of errors and the modes of a Move.
//
// Threads: any. Real-time: noexcept, does not allocate.
namespace twin::fci::wire {

static_assert(std::endian::native == std::endian::little,
              "numbers are copied to the wire as they lie in memory");
static_assert(sizeof(bool) == 1 && sizeof(double) == 8);

/// Bytes of a T on the wire.
template <typename T>
inline constexpr std::size_t kBytes = sizeof(T);
template <>
inline constexpr std::size_t kBytes<RobotErrors> = kRobotErrorCount;
template <>
inline constexpr std::size_t kBytes<MotionModes> = 8;

/// True if T consists of flags, each 0 or 1.
template <typename T>
inline constexpr bool kIsFlags = false;
template <>
inline constexpr bool kIsFlags<bool> = true;
template <>
inline constexpr bool kIsFlags<RobotErrors> = true;
template <std::size_t N>
inline constexpr bool kIsFlags<std::array<bool, N>> = true;

/// True if T is a number with a fraction, or several.
template <typename T>
inline constexpr bool kIsReal = std::is_same_v<T, double>;
template <std::size_t N>
inline constexpr bool kIsReal<std::array<double, N>> = true;

/// True if all `bytes` are 0 or 1.
[[nodiscard]] inline bool AreFlags(std::span<const std::byte> bytes) noexcept {
  std::byte all{};
  for (const std::byte one : bytes) all |= one;
  return all <= std::byte{1};
}

/// @param at  kBytes<T> bytes are written there.
template <typename T>
void Put(std::byte* at, const T& value) noexcept {
  static_assert(std::is_trivially_copyable_v<T>);
  std::memcpy(at, &value, sizeof value);
}

inline void Put(std::byte* at, const RobotErrors& errors) noexcept {
  static_assert(kRobotErrorCount <= 64);
  const std::uint64_t bits = errors.to_ullong();
  for (std::size_t i = 0; i < kRobotErrorCount; ++i) {
    at[i] = static_cast<std::byte>((bits >> i) & 1U);
  }
}

/// A request numbers the generators one lower than the state does; kIdle becomes an unused number.
inline void Put(std::byte* at, const MotionModes& modes) noexcept {
  Put(at, static_cast<std::uint32_t>(modes.controller));
  Put(at + 4, static_cast<std::uint32_t>(modes.generator) - 1U);
}

/// In single precision. @param at  half of kBytes<T> bytes are written there.
template <typename T>
void PutSingle(std::byte* at, const T& value) noexcept {
  static_assert(kIsReal<T>);
  std::array<double, kBytes<T> / sizeof(double)> doubles;
  std::memcpy(doubles.data(), &value, sizeof value);
  for (const double one : doubles) {
    Put(at, static_cast<float>(one));
    at += sizeof(float);
  }
}

/// In single precision. @param at  half of kBytes<T> bytes are read from there.
template <typename T>
void TakeSingle(const std::byte* at, T& value) noexcept {
  static_assert(kIsReal<T>);
  std::array<double, kBytes<T> / sizeof(double)> doubles;
  for (double& one : doubles) {
    float single = 0;
    std::memcpy(&single, at, sizeof single);
    one = static_cast<double>(single);
    at += sizeof single;
  }
  std::memcpy(&value, doubles.data(), sizeof value);
}

/// @param at  kBytes<T> bytes are read from there; flags must be 0 or 1.
template <typename T>
void Take(const std::byte* at, T& value) noexcept {
  static_assert(std::is_trivially_copyable_v<T>);
  std::memcpy(&value, at, sizeof value);
}

inline void Take(const std::byte* at, RobotErrors& errors) noexcept {
  std::uint64_t bits = 0;
  for (std::size_t i = 0; i < kRobotErrorCount; ++i) {
    bits |= static_cast<std::uint64_t>(at[i]) << i;
  }
  errors = RobotErrors(bits);
}

/// Unknown numbers become kOther and kIdle, which no motion uses. Protocol 5 has no kNone: who
/// reads a Move makes it kIdle.
inline void Take(const std::byte* at, MotionModes& modes) noexcept {
  std::uint32_t controller = 0;
  std::uint32_t generator = 0;
  Take(at, controller);
  Take(at + 4, generator);
  modes.controller = controller <= static_cast<std::uint32_t>(ControllerMode::kExternalController)
                         ? static_cast<ControllerMode>(controller)
                         : ControllerMode::kOther;
  modes.generator = generator < static_cast<std::uint32_t>(MotionGeneratorMode::kNone)
                        ? static_cast<MotionGeneratorMode>(generator + 1)
                        : MotionGeneratorMode::kIdle;
}

}  // namespace twin::fci::wire
