#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "twin/core/joint_vector.h"
#include "twin/core/time.h"
#include "twin/record/cycle_record.h"

namespace twin::report {

/// Pairs the measured arm with the workstation's target: the target of the answer to state k with
/// cycle k + 1, in which it acts. Cycles and ticks may come in either order, one side at most 4096
/// records ahead, as in a log with a ring for each. Ticks without q_ext are ignored.
///
/// Threads: one thread. Not real-time.
class TargetMatch {
 public:
  struct Pair {
    Time at{};            ///< of the cycle
    JointVector q{};      ///< measured
    JointVector q_ext{};  ///< target
  };

  TargetMatch() : targets_(kKept), measured_(kKept) {}

  /// @returns a pair completed by this record, else nullopt; times rise.
  std::optional<Pair> Add(const record::CycleRecord& cycle);
  std::optional<Pair> Add(const record::TickRecord& tick);

 private:
  static constexpr std::size_t kKept = 4096;

  struct Entry {
    std::uint64_t message_id = 0;  ///< of the cycle
    Time at{};
    JointVector q{};
  };

  std::vector<Entry> targets_;   ///< slot = message_id modulo size
  std::vector<Entry> measured_;  ///< likewise
};

}  // namespace twin::report
