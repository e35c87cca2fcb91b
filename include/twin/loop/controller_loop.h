#pragma once

#include <cstdint>

#include "twin/control/controller.h"
#include "twin/core/random.h"
#include "twin/core/realtime.h"
#include "twin/loop/exchange.h"
#include "twin/loop/loop_config.h"
#include "twin/reference/feed_forward.h"

namespace twin::loop {

/// The periodic loop of a user's controller as a state machine that any drive can run: wake on the
/// loop's own grid -> update from the newest published state -> after its cost the target is
/// deposited.
///
///     waiting --OnWake--> computing --OnDone--> waiting
///
/// Wake-up n is due when this loop's own clock shows phase + n / rate. That clock runs clock_ppm
/// faster than INT's; the controller sees its time, jitter of the wake-up included, as `now`. A
/// computation that outlasts its period skips to the next wake-up on the grid and is counted: never
/// a burst.
///
/// Threads: the controller's. Real-time: noexcept, allocates nothing.
class ControllerLoop {
 public:
  /// @throws InputError as ControllerLoopConfig::Validate.
  ControllerLoop(const ControllerLoopConfig& config, control::Controller& controller,
                 Exchange& exchange, std::uint64_t seed);

  /// A motion has started: the grid begins at `now` + phase. @returns the first wake-up.
  [[nodiscard]] Time Start(Time now) noexcept;

  /// @returns true when OnDone is due after cost(); false when no state has been published yet.
  [[nodiscard]] bool OnWake(Time now) noexcept TWIN_REALTIME;

  /// Deposits. @returns when to wake next.
  [[nodiscard]] Time OnDone(Time now) noexcept TWIN_REALTIME;

  [[nodiscard]] Duration cost() const noexcept { return current_cost_; }
  /// When to wake next if OnWake returned false.
  [[nodiscard]] Time NextWake(Time now) noexcept TWIN_REALTIME;
  /// Wake-ups skipped because a computation outlasted its period.
  [[nodiscard]] std::uint64_t overruns() const noexcept { return overruns_; }

 private:
  [[nodiscard]] Time Due(std::uint64_t wake) const noexcept;
  [[nodiscard]] Time OwnTime(Time now) const noexcept;

  ControllerLoopConfig config_;
  control::Controller& controller_;
  Exchange& exchange_;
  reference::FeedForward feed_forward_;
  Random wake_random_;
  Random cost_random_;

  Time start_{};
  std::uint64_t wake_ = 0;
  std::uint64_t overruns_ = 0;
  Duration current_cost_{};
  control::ControllerOutput output_;
  Deposit deposit_;
};

}  // namespace twin::loop
