#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "twin/backend/backend.h"
#include "twin/backend/registry.h"
#include "twin/core/joint_vector.h"
#include "twin/core/time.h"
#include "twin/loop/communication_loop.h"

namespace twin::loop {

/// What a run came to.
struct RunReport {
  backend::MotionEnd end = backend::MotionEnd::kNone;
  RobotErrors errors;                 ///< that ended it
  std::vector<Violation> violations;  ///< their details, where known
  std::string failure;                ///< what went wrong, for people; empty when nothing did
  Duration simulated{};               ///< run time at the end
  JointVector q_final{};              ///< measured, last state

  Deviation deviation;                    ///< of the arm from its targets
  LoopTimings timings;                    ///< of the communication
  std::uint64_t controller_overruns = 0;  ///< wake-ups of the controller's loop that were skipped
  backend::RobotTimings robot_timings;    ///< real time: of the simulated robot
  std::vector<std::string> notices;       ///< real time: what the threads were not permitted
  std::vector<record::TickRecord> evidence;  ///< the last ticks, when the workstation's side failed

  /// The motion ended as it should, and nothing else went wrong.
  [[nodiscard]] bool succeeded() const noexcept {
    return end == backend::MotionEnd::kSuccess && failure.empty();
  }
};

/// One line about a tick, for people: what the evidence of a failure reads like.
[[nodiscard]] std::string DescribeTick(const record::TickRecord& tick);

}  // namespace twin::loop
