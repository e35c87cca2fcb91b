#pragma once

#include <array>
#include <bit>
#include <cstdint>

#include "twin/fci/requests.h"

// How a twin identifies itself inside protocol 5, without effect on clients that do not ask. The
// client requests a virtual wall (GetCartesianLimit) with an unused number, which has no side
// effect. A twin answers with a wall whose size is a text.
//
// A real robot cannot match by accident: it returns no size for an undefined wall, and a wall of
// this size would be some 10^267 m long and equal in all 192 bits. A proxy or a tunnel forwards
// request and answer, and so reports what is behind it. The sign prevents mistakes, not deception:
// the protocol has no authentication.
//
// Threads: any.
namespace twin::fci {

/// Number of the requested wall: "twin", little-endian.
inline constexpr std::int32_t kTwinSign = 0x6e697774;

/// Size of the wall in a twin's answer.
inline constexpr std::array<char, sizeof(Vector3)> kTwinSignText{
    'p', 'a', 'n', 'd', 'a', '-', 't', 'w', 'i', 'n', ':', ' ',
    'n', 'o', ' ', 'r', 'e', 'a', 'l', ' ', 'a', 'r', 'm', '.'};

/// A twin's answer.
[[nodiscard]] constexpr CartesianLimit TwinSign() noexcept {
  CartesianLimit wall;
  wall.object_world_size = std::bit_cast<Vector3>(kTwinSignText);
  return wall;
}

[[nodiscard]] constexpr bool IsTwinSign(const CartesianLimit& wall) noexcept {
  return std::bit_cast<std::array<char, sizeof(Vector3)>>(wall.object_world_size) == kTwinSignText;
}

}  // namespace twin::fci
