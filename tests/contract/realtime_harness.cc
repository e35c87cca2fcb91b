// The emulated robot in process, on the wall clock.

#include <pthread.h>
#include <sched.h>

#include <atomic>
#include <chrono>

#include "contract/backend_harness.h"
#include "plugins/mujoco/mujoco_backend.h"
#include "twin/backend/registry.h"
#include "twin/core/clock.h"
#include "twin/rt/thread_setup.h"

namespace twin::test {
namespace {

/// What a thread needs to hold its own beside other load, where the machine permits it.
rt::ThreadSettings Urgent(const char* name, int priority) {
  rt::ThreadSettings settings;
  settings.name = name;
  settings.fifo_priority = priority;
  settings.lock_memory = false;
  settings.stack_kb = 0;
  return settings;
}

/// Makes the calling thread urgent while it lives.
class UrgentHere {
 public:
  UrgentHere() {
    pthread_getschedparam(pthread_self(), &policy_, &parameters_);
    static_cast<void>(rt::SetUpThisThread(Urgent("", 80)));
  }
  ~UrgentHere() { pthread_setschedparam(pthread_self(), policy_, &parameters_); }
  UrgentHere(const UrgentHere&) = delete;
  UrgentHere& operator=(const UrgentHere&) = delete;

 private:
  int policy_ = SCHED_OTHER;
  sched_param parameters_{};
};

/// Notes whether a command came for a cycle that had passed.
class LateCommands final : public rt::RecordSink {
 public:
  void Put(const rt::CycleRecord& record) noexcept override {
    if (record.dropped > 0) any_ = true;
  }
  void Put(const rt::TickRecord&) noexcept override {}
  [[nodiscard]] bool any() const { return any_; }
  void Forget() { any_ = false; }

 private:
  std::atomic<bool> any_ = false;
};

class RealtimeHarness final : public BackendHarness {
 public:
  explicit RealtimeHarness(const robot::RobotConfig& robot) : config_(robot) {
    config_.link.d_INT = Duration::zero();  // the whole period is there for the answer
    backend::Registry registry;
    plugins::RegisterMujoco(registry);
    connection_ = registry.Find("mujoco")(
        {config_, backend::RealtimeHost{clock_, Urgent("robot", 85)}, &late_commands_});
    connection_.robot_time->Begin();
  }
  ~RealtimeHarness() override { connection_.robot_time->End(); }

  backend::Backend& backend() override { return *connection_.backend; }
  backend::Panel* panel() override { return connection_.panel; }
  backend::Hand* hand() override { return connection_.hand; }

  bool AwaitState(RobotState& state, backend::ReadRule rule) override {
    const Time limit = clock_.Now() + std::chrono::seconds(1);
    Time arrival{};
    while (backend().Read(rule, state, arrival) == backend::ReadResult::kPending) {
      if (!connection_.arrival->AwaitUntil(limit) && clock_.Now() >= limit) return false;
    }
    missed_state_ = missed_state_ || state.message_id != last_id_ + 1;
    last_id_ = state.message_id;
    return arrival <= clock_.Now();
  }

  bool AwaitArrivals(int count) override {
    static_cast<void>(connection_.arrival->AwaitUntil(clock_.Now()));  // told of what was read
    for (int i = 0; i < count; ++i) {
      if (!connection_.arrival->AwaitUntil(clock_.Now() + std::chrono::seconds(1))) return false;
    }
    return true;
  }

  bool by_the_wall_clock() const override { return true; }
  bool disturbed() override {
    const bool missed_state = missed_state_;
    // A command that came too late is dropped one or two cycles on.
    RobotState state;
    for (int i = 0; i < 3; ++i) static_cast<void>(AwaitState(state, backend::ReadRule::kNewest));
    return missed_state || late_commands_.any();
  }
  void ForgetDisturbances() override {
    missed_state_ = false;
    late_commands_.Forget();
  }

 private:
  const UrgentHere urgent_;
  const MonotonicClock clock_;
  robot::RobotConfig config_;
  LateCommands late_commands_;
  backend::Connection connection_;
  std::uint64_t last_id_ = 0;
  bool missed_state_ = false;
};

}  // namespace

std::vector<HarnessCase> Harnesses() {
  const auto make = [](const robot::RobotConfig& robot) {
    return std::make_unique<RealtimeHarness>(robot);
  };
  return {{"MujocoPlantInRealtime", robot::PlantKind::kMujoco, make},
          {"IdealPlantInRealtime", robot::PlantKind::kIdeal, make}};
}

}  // namespace twin::test
