#pragma once

#include <bit>
#include <cstdint>
#include <cstring>

#include "record/log_fields.h"
#include "twin/core/robot_state.h"

namespace twin::record {

/// True if two states agree bit by bit in the fields of topic /robot/config.
[[nodiscard]] inline bool SameConfig(const RobotState& a, const RobotState& b) {
  for (const auto& field : kConfigFields) {
    const auto values = field.values(a);
    if (std::memcmp(values.data(), field.values(b).data(), values.size_bytes()) != 0) return false;
  }
  return std::bit_cast<std::uint64_t>(a.m_ee) == std::bit_cast<std::uint64_t>(b.m_ee) &&
         std::bit_cast<std::uint64_t>(a.m_load) == std::bit_cast<std::uint64_t>(b.m_load);
}

}  // namespace twin::record
