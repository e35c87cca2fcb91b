#include "twin/robot/realtime_robot.h"

namespace twin::robot {

void InProcessPort::Write(const RobotCommand& command) noexcept {
  const bool put = commands_.TryPushWith([&](ReceivedCommand& written) {
    written.command = command;
    written.at = clock_.Now();
  });
  if (!put) commands_lost_.fetch_add(1, std::memory_order_relaxed);
}

bool InProcessPort::Receive(ReceivedCommand& received) noexcept {
  return commands_.TryPopWith([&](const ReceivedCommand& written) { received = written; });
}

void InProcessPort::Deliver(const RobotState& state) noexcept {
  states_.Publish(state);
  arrival_.Notify();
}

}  // namespace twin::robot
