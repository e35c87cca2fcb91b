#pragma once

#include <atomic>

#include "twin/core/realtime.h"
#include "twin/rt/latest_value.h"
#include "twin/teleop/operator_sample.h"

namespace twin::page {

/// Connects the page with the device that carries out its operator's input.
///
///     web server's thread --OperatorSample-->   [LatestValue] --> the device's thread
///                         <--OperatorFeedback-- [LatestValue] <--
///
/// Threads: two, as drawn. Real-time: noexcept, does not allocate, never waits.
class OperatorChannel {
 public:
  // The web server's side.

  void Publish(const teleop::OperatorSample& sample) noexcept { samples_.Publish(sample); }
  /// The page has ended: no more samples will follow.
  void End() noexcept { ended_.store(true, std::memory_order_relaxed); }
  /// The newest feedback; null before the first. Valid until the next call.
  [[nodiscard]] const teleop::OperatorFeedback* Feedback() noexcept {
    static_cast<void>(feedback_.Refresh());
    return feedback_.has_value() ? &feedback_.value() : nullptr;
  }

  // The device's side.

  /// @returns the newest sample since the last call, else null. Valid until the next call.
  [[nodiscard]] const teleop::OperatorSample* NewSample() noexcept TWIN_REALTIME {
    return samples_.Refresh() ? &samples_.value() : nullptr;
  }
  void Tell(const teleop::OperatorFeedback& feedback) noexcept TWIN_REALTIME {
    feedback_.Publish(feedback);
  }
  [[nodiscard]] bool ended() const noexcept TWIN_REALTIME {
    return ended_.load(std::memory_order_relaxed);
  }

 private:
  rt::LatestValue<teleop::OperatorSample> samples_;
  rt::LatestValue<teleop::OperatorFeedback> feedback_;
  std::atomic<bool> ended_{false};  ///< relaxed: publishes no other data
};

}  // namespace twin::page
