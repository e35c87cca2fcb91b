#pragma once

#include <cstdint>

#include "twin/control/controller.h"
#include "twin/core/random.h"
#include "twin/core/realtime.h"
#include "twin/loop/exchange.h"
#include "twin/loop/loop_config.h"
#include "twin/reference/feed_forward.h"

namespace twin::loop {

/// Deposits a controller's outputs into the command buffer. First adds the noise of a scenario's
/// imperfect source, uniform in +-target_noise. Then gives a position or pose without a velocity
///   dq_ext = (q_ext(i) - q_ext(i-1)) / (t(i) - t(i-1)),
/// t on the source's clock, zero before the second deposit (reference/feed_forward.h).
///
/// Threads: the controller's. Real-time: noexcept, allocates nothing.
class Depositor {
 public:
  /// @param config  validated. @param exchange  must outlive the object. @param seed  of the noise.
  Depositor(const ControllerLoopConfig& config, control::CommandInterface interface,
            Exchange& exchange, std::uint64_t seed);

  /// Discards the last deposit, at a motion's start.
  void Reset() noexcept;

  /// Nothing for an output that is not fresh.
  /// @param source_time  time at which the source sampled its target, on its own clock, unless the
  /// output says when.
  /// @param based_on     message_id of the state that the controller used.
  void Put(const control::ControllerOutput& output, Time source_time,
           std::uint64_t based_on) noexcept TWIN_REALTIME;

 private:
  void AddNoise() noexcept;

  control::CommandInterface interface_;
  Exchange& exchange_;
  reference::FeedForward joint_;
  reference::PoseFeedForward pose_;
  double noise_;
  Random random_;
  std::uint64_t count_ = 0;
  Deposit deposit_;
};

}  // namespace twin::loop
