#pragma once

#include <cstdint>

#include "twin/control/controller.h"
#include "twin/core/random.h"
#include "twin/core/realtime.h"
#include "twin/loop/exchange.h"
#include "twin/loop/loop_config.h"
#include "twin/reference/feed_forward.h"

namespace twin::loop {

/// Puts a controller's outputs into the command buffer. Here, where commands are deposited, a
/// position or pose without a velocity gets one, over the source's own elapsed time; and here the
/// noise of a scenario's imperfect source is added.
///
/// Threads: the controller's. Real-time: noexcept, allocates nothing.
class Depositor {
 public:
  /// @param config  validated. @param seed  of the noise.
  Depositor(const ControllerLoopConfig& config, control::CommandInterface interface,
            Exchange& exchange, std::uint64_t seed);

  /// Forgets the last deposit: a motion starts.
  void Reset() noexcept;

  /// @param source_time  when the source sampled its target, on its own clock.
  /// @param based_on     message_id of the state the controller had consumed.
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
