#pragma once

#include <cstdint>

// Ids of the hand's states: 32 bits of milliseconds, which begin anew at 0 after 49.7 days. Source:
// FCI protocol 5, gripper.
namespace twin::fci {

/// Whether a state is newer than another one, of the same hand and at most 24.8 days apart.
[[nodiscard]] constexpr bool IsNewer(std::uint32_t id, std::uint32_t than) noexcept {
  return static_cast<std::int32_t>(id - than) > 0;
}

}  // namespace twin::fci
