#include <chrono>

#include "contract/backend_harness.h"
#include "plugins/mujoco/mujoco_backend.h"
#include "support/panda_limits.h"
#include "twin/backend/registry.h"
#include "twin/rt/event_queue.h"

namespace twin::test {
namespace {

class LockstepHarness final : public BackendHarness, private rt::EventHandler {
 public:
  explicit LockstepHarness(robot::PlantKind plant_kind) {
    config_.onboard.limits = PandaLimits();
    config_.onboard.rotor_inertia = {0.6, 0.6, 0.46, 0.46, 0.2, 0.2, 0.2};
    config_.plant_kind = plant_kind;
    config_.plant.urdf = TWIN_SOURCE_DIR "/models/robots/panda/panda.urdf";
    config_.plant.hand = plant::HandKind::kNone;
    config_.link.state_delay = rt::DelayModel(rt::ConstantDelay{std::chrono::microseconds(80)});
    config_.link.command_delay = rt::DelayModel(rt::ConstantDelay{std::chrono::microseconds(80)});
    config_.q_start = kHarnessStart;
    backend::Registry registry;
    plugins::RegisterMujoco(registry);
    connection_ = registry.Find("mujoco")({config_, events_, *this});
  }

  backend::Backend& backend() override { return *connection_.backend; }

  bool AwaitState(RobotState& state) override {
    const Time limit = events_.Now() + std::chrono::seconds(1);
    arrived_ = false;
    while (!arrived_ && events_.Now() < limit && events_.RunNext()) {
    }
    Time arrival{};
    return arrived_ &&
           backend().Read(backend::ReadRule::kFresh, state, arrival) == backend::ReadResult::kState;
  }

 private:
  void OnEvent(Time, std::uint64_t) noexcept override { arrived_ = true; }

  robot::RobotConfig config_;
  rt::EventQueue events_;
  backend::Connection connection_;
  bool arrived_ = false;
};

}  // namespace

HarnessCase MujocoHarness() {
  return {"MujocoPlantInLockstep",
          [] { return std::make_unique<LockstepHarness>(robot::PlantKind::kMujoco); }};
}

HarnessCase IdealPlantHarness() {
  return {"IdealPlantInLockstep",
          [] { return std::make_unique<LockstepHarness>(robot::PlantKind::kIdeal); }};
}

}  // namespace twin::test
