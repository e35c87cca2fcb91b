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

/// Inputs of one motion, for every drive. The references must outlive the run.
struct MotionRun {
  backend::Backend& backend;
  control::Controller& controller;
  MotionModes modes;
  LoopKind kind = LoopKind::kAsynchronous;
  TickConfig tick;
  ControllerLoopConfig controller_loop;
  std::uint64_t seed = 0;              ///< seed of computation times, wake-ups and target noise
  Duration time_limit{};               ///< after this time, the run is stopped and has failed
  record::RecordSink* sink = nullptr;  ///< receives tick records; may be null
  /// Called outside the tick about every 100 ms of the run's time; may be empty.
  std::function<void(Time)> progress;
  /// Receives events for the log: (time, kind, text). May be empty.
  std::function<void(Time, std::string_view, std::string_view)> event;
  /// A signal handler sets it to stop the motion and end the run. May be null.
  const volatile bool* interrupted = nullptr;
  Duration silence = std::chrono::seconds(1);  ///< without a state, after which the run has failed
  /// Work beside the motion, such as hand commands. Called outside the tick at the run's start, and
  /// again at the time that it has returned. In real time it may block. May be empty.
  std::function<Time(Time now)> attend{};
};

}  // namespace twin::loop
