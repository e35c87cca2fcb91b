#pragma once

#include <array>
#include <bit>
#include <cstdint>

#include "twin/fci/requests.h"

// How a twin says that it is one, inside protocol 5 and unnoticed by whoever does not ask. A client
// asks for a virtual wall (GetCartesianLimit) of a number that nobody gives one, a request without
// any effect; a twin answers with a wall whose size is a text.
//
// Why no robot says so by accident: of a wall that it does not have it gives none, and one of its
// own would be some 10^267 m long, equal in all 192 bits. What stands between client and robot (a
// proxy, a tunnel) hands the request and its answer on, and so speaks for what is behind it. The
// protocol has no secrets: this keeps from mistakes, not from programs that lie.
//
// Threads: any.
namespace twin::fci {

/// The wall that is asked for: "twin", little-endian.
inline constexpr std::int32_t kTwinSign = 0x6e697774;

/// Its size, as a twin answers.
inline constexpr std::array<char, sizeof(Vector3)> kTwinSignText{
    'p', 'a', 'n', 'd', 'a', '-', 't', 'w', 'i', 'n', ':', ' ',
    'n', 'o', ' ', 'r', 'e', 'a', 'l', ' ', 'a', 'r', 'm', '.'};

/// What a twin answers.
[[nodiscard]] constexpr CartesianLimit TwinSign() noexcept {
  CartesianLimit wall;
  wall.object_world_size = std::bit_cast<Vector3>(kTwinSignText);
  return wall;
}

[[nodiscard]] constexpr bool IsTwinSign(const CartesianLimit& wall) noexcept {
  return std::bit_cast<std::array<char, sizeof(Vector3)>>(wall.object_world_size) == kTwinSignText;
}

}  // namespace twin::fci
