#pragma once

#include <optional>

#include "report/target_match.h"
#include "twin/core/joint_vector.h"
#include "twin/core/time.h"
#include "twin/record/cycle_record.h"

namespace twin::report {

/// How far the measured arm is from where it is wanted, out of a run's records:
///   error = q_d - q          of one cycle, while the robot follows a reference, and after that
///                            while it comes to rest;
///   error = q_ext - q        under torques, where q_d stands still: of TargetMatch.
///
/// Threads: one thread. Real-time: no.
class TrackingError {
 public:
  struct Value {
    Time at{};
    JointVector error{};  ///< rad
  };

  /// @returns an error that is now known; their times rise.
  std::optional<Value> Add(const record::CycleRecord& cycle);
  std::optional<Value> Add(const record::TickRecord& tick);

  /// Whether any cycle so far was one under torques.
  [[nodiscard]] bool by_torque() const { return by_torque_; }

 private:
  TargetMatch match_;
  bool by_reference_ = false;  ///< the last motion is, or was, of a reference
  bool by_torque_ = false;
};

}  // namespace twin::report
