#pragma once

#include <array>
#include <bit>
#include <bitset>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <type_traits>
#include <vector>

namespace twin::fci {

using Bytes = std::vector<std::byte>;

/// "0500 caa8" as bytes; blanks count for nothing.
inline Bytes Hex(std::string_view text) {
  const auto digit = [](char c) { return c <= '9' ? c - '0' : c - 'a' + 10; };
  Bytes bytes;
  int high = -1;
  for (const char c : text) {
    if (c == ' ') continue;
    if (high < 0) {
      high = digit(c);
    } else {
      bytes.push_back(static_cast<std::byte>(16 * high + digit(c)));
      high = -1;
    }
  }
  return bytes;
}

inline Bytes ToBytes(std::span<const std::byte> span) {
  return {span.begin(), span.end()};
}

/// Writes little-endian bytes one by one by arithmetic, independently of how the product does.
class BytePacker {
 public:
  template <typename T>
  BytePacker& Put(const T& value) {
    if constexpr (std::is_same_v<T, double>) {
      PutBits(std::bit_cast<std::uint64_t>(value), 8);
    } else if constexpr (std::is_same_v<T, bool>) {
      PutBits(value ? 1 : 0, 1);
    } else {
      PutBits(static_cast<std::uint64_t>(value), sizeof(T));
    }
    return *this;
  }
  template <typename T, std::size_t N>
  BytePacker& Put(const std::array<T, N>& values) {
    for (const T& value : values) Put(value);
    return *this;
  }
  template <std::size_t N>
  BytePacker& Put(const std::bitset<N>& flags) {
    for (std::size_t i = 0; i < N; ++i) Put(flags.test(i));
    return *this;
  }

  [[nodiscard]] std::size_t size() const { return bytes_.size(); }
  [[nodiscard]] const Bytes& bytes() const { return bytes_; }

 private:
  void PutBits(std::uint64_t bits, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) {
      bytes_.push_back(static_cast<std::byte>(bits / (std::uint64_t{1} << (8 * i)) % 256));
    }
  }

  Bytes bytes_;
};

}  // namespace twin::fci
