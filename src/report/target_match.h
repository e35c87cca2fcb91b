#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "twin/core/joint_vector.h"
#include "twin/core/time.h"
#include "twin/record/cycle_record.h"

namespace twin::report {

/// Brings together where the arm was measured and where the workstation's target wanted it: of the
/// target that came with the answer to state k, and cycle k + 1, in which that acts. Cycles and
/// ticks may come in either order, one side at most 4096 records ahead, as in a log with a ring for
/// each. A tick without q_ext gives nothing.
///
/// Threads: one thread. Real-time: no.
class TargetMatch {
 public:
  struct Pair {
    Time at{};            ///< of the cycle
    JointVector q{};      ///< measured
    JointVector q_ext{};  ///< target
  };

  TargetMatch() : targets_(kKept), measured_(kKept) {}

  /// @returns a pair that is now complete; their times rise.
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
  std::vector<Entry> measured_;  ///< the same
};

}  // namespace twin::report
