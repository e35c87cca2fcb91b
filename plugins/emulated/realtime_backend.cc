#include "plugins/emulated/emulated_backend.h"

#include <memory>
#include <utility>

#include "twin/robot/realtime_robot.h"

namespace twin::plugins {
namespace {

class RealtimeBackend final : public EmulatedBackend<robot::RealtimeRobot>,
                              public backend::RealtimeRobotControl {
 public:
  RealtimeBackend(const backend::Request& request, const backend::WallTime& time, NamedPlant plant)
      : EmulatedBackend(std::move(plant.name), request.robot, std::move(plant.plant), time.clock,
                        time.robot_thread, request.sink),
        clock_(time.clock) {}

  [[nodiscard]] rt::Arrival& arrival() noexcept { return robot().arrival(); }

  backend::ReadResult Read(backend::ReadRule rule, RobotState& state,
                           Time& arrival) noexcept override {
    const RobotState* newest = robot().Read();
    const bool may_be_queued = rule == backend::ReadRule::kFresh && !found_none_;
    if (newest == nullptr || may_be_queued) {
      found_none_ = true;  // also after discarding a queued state: the queue is empty
      return backend::ReadResult::kPending;
    }
    found_none_ = false;
    state = *newest;
    arrival = clock_.Now();
    return backend::ReadResult::kState;
  }

  void Write(const RobotCommand& command) noexcept override { robot().Write(command); }

  void Begin() override { robot().Begin(); }
  void StandBy() override { robot().StandBy(); }
  void End() override { robot().End(); }
  [[nodiscard]] backend::RobotTimings timings() const override {
    return {.lateness = robot().lateness(),
            .overruns = robot().overruns(),
            .commands_lost = robot().commands_lost(),
            .notices = robot().notices()};
  }

 private:
  const MonotonicClock& clock_;
  bool found_none_ = false;  ///< the last Read() left the queue empty: the next state is fresh
};

}  // namespace

void ConnectRealtime(const backend::Request& request, const backend::WallTime& time,
                     NamedPlant plant, backend::Connection& connection) {
  auto backend = std::make_unique<RealtimeBackend>(request, time, std::move(plant));
  connection.arrival = &backend->arrival();
  connection.robot_time = backend.get();
  connection.panel = backend.get();
  connection.hand = backend->hand();
  connection.base = backend->base();
  connection.backend = std::move(backend);
}

}  // namespace twin::plugins
