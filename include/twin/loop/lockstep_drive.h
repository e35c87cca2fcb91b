#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string_view>

#include "twin/backend/backend.h"
#include "twin/control/controller.h"
#include "twin/loop/loop_config.h"
#include "twin/loop/run_report.h"
#include "twin/rt/cycle_record.h"
#include "twin/rt/event_queue.h"

namespace twin::loop {

/// Everything one lockstep run needs. The references must outlive the run.
struct LockstepRun {
  rt::EventQueue& events;  ///< the virtual clock; the backend's robot is on it
  backend::Backend& backend;
  control::Controller& controller;
  MotionModes modes;
  TickConfig tick;
  ControllerLoopConfig controller_loop;
  std::uint64_t seed = 0;          ///< of computation times and wake-ups
  Duration time_limit{};           ///< the run is stopped and reported as failed after this
  rt::RecordSink* sink = nullptr;  ///< tick records; may be null
  /// Called outside the tick about once per simulated 100 ms with the run's time; may be empty.
  std::function<void(Time)> progress;
  /// Called at changes worth a line in the log: (time, kind, text). May be empty.
  std::function<void(Time, std::string_view, std::string_view)> event;
  /// Set from a signal handler: the motion is stopped, the run ends. May be null.
  const volatile bool* interrupted = nullptr;
};

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

  /// @throws InputError from the controller's activation, RobotFault when the motion is refused. A
  /// motion that starts and then fails is no exception: the report says how it ended.
  [[nodiscard]] RunReport Run(const LockstepRun& run);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace twin::loop
