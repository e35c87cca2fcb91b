#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "twin/core/joint_vector.h"
#include "twin/core/time.h"
#include "twin/rt/cycle_record.h"

namespace twin::report {

/// How far the measured arm is from where it is wanted, out of a run's records:
///   error = q_d - q          of one cycle, while the robot follows a reference, and after that
///                            while it comes to rest;
///   error = q_ext - q        under torques, where q_d stands still: of the target that came with
///                            the answer to state k, and cycle k + 1, in which it acts.
/// Cycles and ticks may come in either order, one side at most 4096 records ahead, as in a log with
/// a ring for each. A tick without q_ext gives nothing.
///
/// Threads: one thread. Real-time: no.
class TrackingError {
 public:
  struct Value {
    Time at{};
    JointVector error{};  ///< rad
  };

  TrackingError() : targets_(kKept), measured_(kKept) {}

  /// @returns an error that is now known; their times rise.
  std::optional<Value> Add(const rt::CycleRecord& cycle);
  std::optional<Value> Add(const rt::TickRecord& tick);

  /// Whether any cycle so far was one under torques.
  [[nodiscard]] bool by_torque() const { return by_torque_; }

 private:
  static constexpr std::size_t kKept = 4096;

  struct Entry {
    std::uint64_t message_id = 0;  ///< of the cycle
    Time at{};
    JointVector q{};
  };

  std::vector<Entry> targets_;   ///< slot = message_id modulo size
  std::vector<Entry> measured_;  ///< the same
  bool by_reference_ = false;    ///< the last motion is, or was, of a reference
  bool by_torque_ = false;
};

}  // namespace twin::report
