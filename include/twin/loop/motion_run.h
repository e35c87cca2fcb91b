#pragma once

#include <cstdint>
#include <functional>
#include <string_view>

#include "twin/backend/backend.h"
#include "twin/control/controller.h"
#include "twin/core/modes.h"
#include "twin/core/time.h"
#include "twin/loop/loop_config.h"
#include "twin/record/cycle_record.h"

namespace twin::loop {

/// One motion, whoever advances time. The references must outlive the run.
struct MotionRun {
  backend::Backend& backend;
  control::Controller& controller;
  MotionModes modes;
  LoopKind kind = LoopKind::kAsynchronous;
  TickConfig tick;
  ControllerLoopConfig controller_loop;
  std::uint64_t seed = 0;              ///< of computation times, wake-ups and target noise
  Duration time_limit{};               ///< the run is stopped and reported as failed after this
  record::RecordSink* sink = nullptr;  ///< tick records; may be null
  /// Called outside the tick about every 100 ms of the run's time; may be empty.
  std::function<void(Time)> progress;
  /// Called at changes worth a line in the log: (time, kind, text). May be empty.
  std::function<void(Time, std::string_view, std::string_view)> event;
  /// Set from a signal handler: the motion is stopped, the run ends. May be null.
  const volatile bool* interrupted = nullptr;
  /// What is done beside the motion, the hand's commands: called outside the tick as the run
  /// begins, and again as soon as its time has come to what was returned. In real time its thread
  /// may wait. May be empty.
  std::function<Time(Time now)> attend{};
};

}  // namespace twin::loop
