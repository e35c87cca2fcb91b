#include "plugins/emulated/emulated_backend.h"

#include <memory>
#include <utility>

namespace twin::plugins {
namespace {

class LockstepBackend final : public EmulatedBackend<robot::Robot> {
 public:
  LockstepBackend(const backend::Request& request, const backend::VirtualTime& time,
                  NamedPlant plant)
      : EmulatedBackend(std::move(plant.name), request.robot, std::move(plant.plant), time.events,
                        time.state_ready, request.sink),
        events_(time.events) {
    robot().Begin();
  }

  // A reader at the instant of an arrival has waited for it.
  backend::ReadResult Read(backend::ReadRule rule, RobotState& state,
                           Time& arrival) noexcept override {
    robot::StateLink& states = robot().states();
    if (!states.has_new()) return backend::ReadResult::kPending;
    const RobotState& newest = states.Take();
    const bool stale = rule == backend::ReadRule::kFresh && states.arrival() != events_.Now();
    if (stale) return backend::ReadResult::kPending;
    state = newest;
    arrival = states.arrival();
    return backend::ReadResult::kState;
  }

  void Write(const RobotCommand& command) noexcept override { robot().Send(command); }

  [[nodiscard]] robot::Robot* lockstep_robot() noexcept { return &robot(); }

 private:
  const rt::EventQueue& events_;
};

}  // namespace

void ConnectLockstep(const backend::Request& request, const backend::VirtualTime& time,
                     NamedPlant plant, backend::Connection& connection) {
  auto backend = std::make_unique<LockstepBackend>(request, time, std::move(plant));
  connection.panel = backend.get();
  connection.hand = backend->hand();
  connection.base = backend->base();
  connection.lockstep_robot = backend->lockstep_robot();
  connection.backend = std::move(backend);
}

}  // namespace twin::plugins
