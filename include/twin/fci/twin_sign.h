#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <string_view>

#include "twin/fci/requests.h"

// How a twin identifies itself inside protocol 5, without effect on clients that do not ask. The
// client requests a virtual wall (GetCartesianLimit) with an unused number, which has no side
// effect. A twin answers with a wall whose size is a text. If it is served in lockstep, the first
// element of the wall's frame is a text too.
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

/// First element of the wall's frame, if the twin is served in lockstep.
inline constexpr std::array<char, sizeof(double)> kLockstepText{'l', 'o', 'c', 'k',
                                                                's', 't', 'e', 'p'};

/// What a robot says of itself.
enum class TwinKind : std::uint8_t {
  kNone,        ///< nothing: it may be a real arm
  kOnClock,     ///< a twin; its cycle is due every 1 ms, answered or not
  kInLockstep,  ///< a twin that waits for the answer to each of its states
};

/// A twin's answer. @pre kind is not kNone.
[[nodiscard]] constexpr CartesianLimit TwinSign(TwinKind kind) noexcept {
  CartesianLimit wall;
  wall.object_world_size = std::bit_cast<Vector3>(kTwinSignText);
  if (kind == TwinKind::kInLockstep) wall.object_frame[0] = std::bit_cast<double>(kLockstepText);
  return wall;
}

[[nodiscard]] constexpr TwinKind TwinKindOf(const CartesianLimit& wall) noexcept {
  if (std::bit_cast<std::array<char, sizeof(Vector3)>>(wall.object_world_size) != kTwinSignText) {
    return TwinKind::kNone;
  }
  const auto waits = std::bit_cast<std::array<char, sizeof(double)>>(wall.object_frame[0]);
  return waits == kLockstepText ? TwinKind::kInLockstep : TwinKind::kOnClock;
}

/// In protocol 10, which has no virtual walls, the URDF of a twin ends with one of these comments.
inline constexpr std::string_view kTwinComment = "<!-- panda-twin: no real arm -->\n";
inline constexpr std::string_view kLockstepComment = "<!-- panda-twin: no real arm, lockstep -->\n";

/// What the URDF of a robot's answer to GetRobotModel says.
[[nodiscard]] constexpr TwinKind TwinKindOf(std::string_view urdf) noexcept {
  if (urdf.ends_with(kLockstepComment)) return TwinKind::kInLockstep;
  return urdf.ends_with(kTwinComment) ? TwinKind::kOnClock : TwinKind::kNone;
}

}  // namespace twin::fci
