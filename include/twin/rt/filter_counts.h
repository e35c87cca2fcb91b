#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "twin/core/joint_vector.h"
#include "twin/core/realtime.h"
#include "twin/core/time.h"
#include "twin/rt/cycle_record.h"

namespace twin::rt {

/// What a viability filter made of the commands of a run.
struct FilterCounts {
  /// Where the reference came nearest to the border of what can be kept legal.
  struct Nearest {
    double margin = 0;  ///< as TickRecord::margin
    Time at{};          ///< the state's read
  };

  std::uint64_t commands = 0;                     ///< that passed the filter
  std::uint64_t kept_back = 0;                    ///< of those, changed for one joint or more
  std::array<std::uint64_t, kJoints> of_joint{};  ///< changed for this joint
  std::optional<Nearest> nearest{};               ///< absent: no command passed a filter

  /// Share of the commands that were changed, %; 0 of none.
  [[nodiscard]] double kept_back_percent() const noexcept;

  /// One tick more; those that wrote nothing, or had no filter, do not count. Real-time: noexcept,
  /// allocates nothing.
  void Add(const TickRecord& tick) noexcept TWIN_REALTIME;
};

}  // namespace twin::rt
