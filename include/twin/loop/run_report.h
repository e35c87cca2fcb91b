#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "twin/backend/backend.h"
#include "twin/core/joint_vector.h"
#include "twin/core/time.h"

namespace twin::loop {

/// What a run came to.
struct RunReport {
  backend::MotionEnd end = backend::MotionEnd::kNone;
  RobotErrors errors;                 ///< that ended it
  std::vector<Violation> violations;  ///< their details, where known
  std::string failure;                ///< what went wrong, for people; empty when nothing did
  Duration simulated{};               ///< run time at the end
  std::uint64_t written = 0;          ///< commands written
  std::uint64_t skipped_states = 0;   ///< states that never reached the workstation
  JointVector q_final{};              ///< measured, last state

  /// The motion ended as it should, and nothing else went wrong.
  [[nodiscard]] bool succeeded() const noexcept {
    return end == backend::MotionEnd::kSuccess && failure.empty();
  }
};

}  // namespace twin::loop
