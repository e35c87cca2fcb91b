#pragma once

#include <memory>

#include "twin/loop/motion_run.h"
#include "twin/loop/run_report.h"
#include "twin/rt/event_queue.h"

namespace twin::loop {

/// Runs a motion from start to end on the virtual clock: event queue, state arrival -> tick,
/// periodic controller loop. One thread; the same inputs and seed give the same records.
///
/// The backend must have been connected with `state_ready` = StateReady() of this drive.
class LockstepDrive {
 public:
  LockstepDrive();
  ~LockstepDrive();
  LockstepDrive(const LockstepDrive&) = delete;
  LockstepDrive& operator=(const LockstepDrive&) = delete;

  /// What a backend calls (through its request) when a state has arrived on this side.
  [[nodiscard]] rt::EventHandler& StateReady() noexcept;

  /// @param events  the virtual clock; the backend's robot is on it.
  /// @throws InputError from the controller's activation, RobotFault when the motion is refused. A
  /// motion that starts and then fails is no exception: the report says how it ended.
  [[nodiscard]] RunReport Run(rt::EventQueue& events, const MotionRun& run);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace twin::loop
