#include "twin/loop/drive.h"

#include "loop/motion_runner.h"
#include "twin/core/error.h"

namespace twin::loop {
namespace {

[[noreturn]] void RefuseToGoBack() {
  throw InputError(
      "only a robot simulated in lockstep can be saved and restored: a clock does not go back; say "
      "drive: lockstep, with backend mujoco");
}

}  // namespace

std::unique_ptr<const Drive::Snapshot> Drive::Save() const {
  RefuseToGoBack();
}

void Drive::Restore(const Snapshot& /*snapshot*/) {
  RefuseToGoBack();
}

bool Drive::PassUntil(Time limit, const std::function<bool(const RobotState*)>& done) {
  backend::Backend& backend = *connection().backend;
  const auto now = [this] { return wall_clock() != nullptr ? wall_clock()->Now() : Now(); };
  Time heard = now();
  Time arrival{};
  // Discards the old states in the queue.
  static_cast<void>(backend.Read(backend::ReadRule::kNewest, state_, arrival));
  while (true) {
    const RobotState* read = nullptr;
    switch (backend.Read(backend::ReadRule::kFresh, state_, arrival)) {
      case backend::ReadResult::kPending: break;
      case backend::ReadResult::kLost: {
        const auto& why = connection().why_lost;
        throw RobotFault("the connection to the robot is gone" + (why ? ": " + why() : ""));
      }
      case backend::ReadResult::kState:
        read = &state_;
        heard = now();
        Observe(state_);
        break;
    }
    if (done(read)) return true;
    if (Now() >= limit) return false;
    if (now() - heard > connection().silence) throw RobotFault(NoStateFor(connection().silence));
    Wait(limit);
  }
}

}  // namespace twin::loop
