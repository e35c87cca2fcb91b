#pragma once

#include <array>
#include <bit>
#include <cstdint>

namespace twin::test {

/// The bits of what consists of doubles alone: of equal bits, unlike of equal values, no sign of a
/// zero differs.
template <typename Doubles>
std::array<std::uint64_t, sizeof(Doubles) / sizeof(double)> Bits(const Doubles& x) noexcept {
  return std::bit_cast<std::array<std::uint64_t, sizeof(Doubles) / sizeof(double)>>(x);
}

}  // namespace twin::test
