#pragma once

#include <optional>

#include "report/target_match.h"
#include "twin/core/joint_vector.h"
#include "twin/core/time.h"
#include "twin/record/cycle_record.h"

namespace twin::report {

/// Tracking error of the measured arm, from a run's records:
///   error = q_d - q          in a cycle in which the robot follows a reference, and afterwards
///                            until it is at rest;
///   error = q_ext - q        under torques, where q_d is constant: by TargetMatch.
///
/// Threads: one thread. Not real-time.
class TrackingError {
 public:
  struct Value {
    Time at{};
    JointVector error{};  ///< rad
  };

  /// @returns the error completed by this record, else nullopt; times rise.
  std::optional<Value> Add(const record::CycleRecord& cycle);
  std::optional<Value> Add(const record::TickRecord& tick);

  /// True if any cycle so far was under torques.
  [[nodiscard]] bool by_torque() const { return by_torque_; }

 private:
  TargetMatch match_;
  bool by_reference_ = false;  ///< the current or last motion has a reference
  bool by_torque_ = false;
};

}  // namespace twin::report
