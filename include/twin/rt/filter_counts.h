#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "twin/core/joint_vector.h"
#include "twin/core/realtime.h"
#include "twin/core/time.h"
#include "twin/rt/cycle_record.h"

namespace twin::rt {

/// Statistics of a viability filter over a run.
struct FilterCounts {
  /// Closest approach of the reference to the border of the viable set.
  struct Nearest {
    double margin = 0;  ///< as TickRecord::margin
    Time at{};          ///< time of the state's read
  };

  std::uint64_t commands = 0;                     ///< that passed the filter
  std::uint64_t kept_back = 0;                    ///< of those, changed in at least one joint
  std::array<std::uint64_t, kJoints> of_joint{};  ///< changed for this joint
  std::optional<Nearest> nearest{};               ///< absent without filtered commands

  /// Share of changed commands, %; 0 without commands.
  [[nodiscard]] double kept_back_percent() const noexcept;

  /// Adds a tick; ticks without a written or filtered command do not count. Real-time: noexcept,
  /// allocates nothing.
  void Add(const TickRecord& tick) noexcept TWIN_REALTIME;
};

}  // namespace twin::rt
