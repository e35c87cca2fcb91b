#pragma once

#include <cstdint>

#include "twin/control/controller.h"
#include "twin/core/random.h"
#include "twin/core/realtime.h"
#include "twin/loop/depositor.h"
#include "twin/loop/exchange.h"
#include "twin/loop/loop_config.h"
#include "twin/loop/wake_grid.h"

namespace twin::loop {

/// The periodic loop of a user's controller as a state machine that every drive can run: wake on
/// the loop's own grid -> update from the newest published state -> deposit after cost().
///
///     waiting --OnWake--> computing --OnDone--> waiting
///
/// A WakeGrid determines the wake-ups. The controller's `now` is the grid's time, including the
/// jitter of the wake-up.
///
/// Threads: the controller's. Real-time: noexcept, allocates nothing.
class ControllerLoop {
 public:
  /// @throws InputError as ControllerLoopConfig::Validate().
  ControllerLoop(const ControllerLoopConfig& config, control::Controller& controller,
                 Exchange& exchange, std::uint64_t seed);

  /// Starts a motion: the grid begins at `now` + phase. @returns the first wake-up.
  [[nodiscard]] Time Start(Time now) noexcept TWIN_REALTIME;

  /// @returns true when OnDone is due after cost(); false when no state has been published yet.
  [[nodiscard]] bool OnWake(Time now) noexcept TWIN_REALTIME;

  /// Deposits the target. @returns the next wake-up.
  [[nodiscard]] Time OnDone(Time now) noexcept TWIN_REALTIME;

  [[nodiscard]] Duration cost() const noexcept { return current_cost_; }
  /// The next wake-up after OnWake() has returned false.
  [[nodiscard]] Time NextWake(Time now) noexcept TWIN_REALTIME { return grid_.Next(now); }
  /// Wake-ups skipped because a computation outlasted its period.
  [[nodiscard]] std::uint64_t overruns() const noexcept { return grid_.overruns(); }

 private:
  control::Controller& controller_;
  Exchange& exchange_;
  Depositor depositor_;
  WakeGrid grid_;
  faults::DelayModel cost_;
  Random cost_random_;

  Duration current_cost_{};
  Time source_time_{};
  std::uint64_t based_on_ = 0;
  control::ControllerOutput output_;
};

}  // namespace twin::loop
