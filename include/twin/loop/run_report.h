#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "twin/backend/backend.h"
#include "twin/backend/registry.h"
#include "twin/core/joint_vector.h"
#include "twin/core/time.h"
#include "twin/loop/communication_loop.h"
#include "twin/onboard/stop_proof.h"

namespace twin::loop {

/// Result of a run.
struct RunReport {
  backend::MotionEnd end = backend::MotionEnd::kNone;
  RobotErrors errors;                           ///< errors that ended the motion
  std::vector<Violation> violations;            ///< their details, where known
  std::optional<onboard::BrokenLimit> limit{};  ///< the lab's limit before which the tick stopped
  std::string failure;                          ///< cause of a failure, for users; empty: none
  Duration simulated{};                         ///< run time at the end
  JointVector q_final{};                        ///< measured, last state

  Deviation deviation;                    ///< of the arm from its targets
  LoopTimings timings;                    ///< of the communication
  std::uint64_t controller_overruns = 0;  ///< skipped wake-ups of the controller's loop
  backend::RobotTimings robot_timings;    ///< real time: of the simulated robot
  std::vector<std::string> notices;  ///< real time: thread settings that the system did not permit
  std::vector<record::TickRecord> evidence;  ///< the last ticks, when the workstation's side failed

  /// True when the motion ended successfully and no failure occurred.
  [[nodiscard]] bool succeeded() const noexcept {
    return end == backend::MotionEnd::kSuccess && failure.empty();
  }
};

/// One line of text about a tick, for a failure's evidence.
[[nodiscard]] std::string DescribeTick(const record::TickRecord& tick);

}  // namespace twin::loop
