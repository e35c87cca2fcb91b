#pragma once

#include <cstdint>

#include "twin/core/robot_state.h"
#include "twin/core/time.h"
#include "twin/reference/target.h"
#include "twin/rt/latest_value.h"

namespace twin::loop {

/// What the tick shows the controller side: the newest state and when it was read.
struct PublishedState {
  RobotState state;
  Time read{};
};

/// What the controller side hands to the tick.
struct Deposit {
  reference::Target target;    ///< with the feed-forward velocity formed
  Time source_time{};          ///< the source's own time of the target
  std::uint64_t based_on = 0;  ///< message_id of the state the controller had consumed
  bool finished = false;       ///< the target is the end of the task
  bool failed = false;         ///< the controller gave up
};

/// The two buffers between the communication side (the tick) and the controller side. Each side
/// only copies from and to them; neither ever waits for the other. Source: the paper's section on
/// the asynchronous thread.
///
/// Threads: the tick's thread produces states and consumes deposits, the controller's the other
/// way.
struct Exchange {
  rt::LatestValue<PublishedState> states;
  rt::LatestValue<Deposit> deposits;
};

}  // namespace twin::loop
