#pragma once

#include <cstdint>

#include "twin/core/robot_state.h"
#include "twin/core/time.h"
#include "twin/reference/target.h"
#include "twin/rt/latest_value.h"

namespace twin::loop {

/// Data from the tick to the controller side: the newest state and the end of its read.
struct PublishedState {
  RobotState state;
  Time read{};
};

/// Data from the controller side to the tick.
struct Deposit {
  reference::Target target;    ///< with its feed-forward velocity
  Time source_time{};          ///< time of the target on the source's clock
  std::uint64_t based_on = 0;  ///< message_id of the state that the controller used
  bool finished = false;       ///< the target is the end of the task
  bool failed = false;         ///< the controller has given up
};

/// The two buffers between the communication side (the tick) and the controller side. Both sides
/// only copy to and from them and never wait for each other. Source: the paper's section on the
/// asynchronous thread.
///
/// Threads: the tick's produces states and consumes deposits; the controller's does the reverse.
struct Exchange {
  rt::LatestValue<PublishedState> states;
  rt::LatestValue<Deposit> deposits;
};

}  // namespace twin::loop
