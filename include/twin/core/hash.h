#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <string>

namespace twin {

/// Hash of a sequence of 64-bit words: FNV-1a on words instead of bytes, with a shift that mixes
/// the high bits into the low ones. Not secure against adversaries.
///
/// Real-time: noexcept, O(1) a word, no allocation.
class WordHash {
 public:
  void AddWord(std::uint64_t word) noexcept {
    value_ = (value_ ^ word) * 0x100000001b3;
    value_ ^= value_ >> 32;
  }
  void AddNumber(double number) noexcept { AddWord(std::bit_cast<std::uint64_t>(number)); }
  void AddNumbers(const double* numbers, std::size_t count) noexcept {
    for (std::size_t i = 0; i < count; ++i) AddNumber(numbers[i]);
  }
  [[nodiscard]] std::uint64_t value() const noexcept { return value_; }

 private:
  std::uint64_t value_ = 0xcbf29ce484222325;
};

/// Identifies the variant of the C library's mathematics: a hash of sin, cos, exp, log, pow, atan2
/// at fixed points. glibc selects code with different last bits on processors with and without
/// fused multiply-add; runs repeat bit by bit only within one variant.
[[nodiscard]] std::uint64_t LibmFingerprint();

/// @returns 16 hexadecimal digits.
[[nodiscard]] std::string FormatHash(std::uint64_t hash);

}  // namespace twin
