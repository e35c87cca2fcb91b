// The emulated robot in process, on the virtual clock.

#include <chrono>

#include "contract/backend_harness.h"
#include "plugins/backends.h"
#include "twin/backend/registry.h"
#include "twin/rt/event_queue.h"

namespace twin::test {
namespace {

class LockstepHarness final : public BackendHarness, private rt::EventHandler {
 public:
  explicit LockstepHarness(const robot::RobotConfig& robot) : config_(robot) {
    config_.link.state.delay =
        faults::DelayModel(faults::ConstantDelay{std::chrono::microseconds(80)});
    config_.link.command.delay =
        faults::DelayModel(faults::ConstantDelay{std::chrono::microseconds(80)});
    backend::Registry registry;
    plugins::RegisterMujoco(registry);
    connection_ = registry.Find("mujoco")({config_, backend::VirtualTime{events_, *this}});
  }

  backend::Backend& backend() override { return *connection_.backend; }
  backend::Panel* panel() override { return connection_.panel; }
  backend::Hand* hand() override { return connection_.hand; }

  bool AwaitState(RobotState& state, backend::ReadRule rule) override {
    Time arrival{};
    return RunUntilArrival() &&
           backend().Read(rule, state, arrival) == backend::ReadResult::kState &&
           arrival == events_.Now();
  }

  bool AwaitArrivals(int count) override {
    for (int i = 0; i < count; ++i) {
      if (!RunUntilArrival()) return false;
    }
    return events_.RunNext();  // on, to an instant at which none arrives
  }

 private:
  void OnEvent(Time, std::uint64_t) noexcept override { arrived_ = true; }

  bool RunUntilArrival() {
    const Time limit = events_.Now() + std::chrono::seconds(1);
    arrived_ = false;
    while (!arrived_ && events_.Now() < limit && events_.RunNext()) {
    }
    return arrived_;
  }

  robot::RobotConfig config_;
  rt::EventQueue events_;
  backend::Connection connection_;
  bool arrived_ = false;
};

}  // namespace

std::vector<HarnessCase> Harnesses() {
  const auto make = [](const robot::RobotConfig& robot) {
    return std::make_unique<LockstepHarness>(robot);
  };
  return {{"MujocoPlantInLockstep", robot::PlantKind::kMujoco, make},
          {"IdealPlantInLockstep", robot::PlantKind::kIdeal, make}};
}

}  // namespace twin::test
