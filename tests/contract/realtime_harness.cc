// The emulated robot in process, on the wall clock.

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>

#include "contract/backend_harness.h"
#include "contract/urgent.h"
#include "plugins/backends.h"
#include "twin/backend/registry.h"
#include "twin/core/clock.h"

namespace twin::test {
namespace {

/// Longer than any machine holds up a thread.
constexpr Duration kLong = std::chrono::seconds(30);

/// Notes whether a command came for a cycle that had passed.
class LateCommands final : public record::RecordSink {
 public:
  void Put(const record::CycleRecord& record) noexcept override {
    if (record.dropped > 0) any_ = true;
  }
  void Put(const record::TickRecord&) noexcept override {}
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
        {config_, backend::WallTime{clock_, Urgent("robot", 85)}, &late_commands_});
    connection_.robot_time->Begin();
  }
  ~RealtimeHarness() override { connection_.robot_time->End(); }

  backend::Backend& backend() override { return *connection_.backend; }
  backend::Panel* panel() override { return connection_.panel; }
  backend::Hand* hand() override { return connection_.hand; }

  bool AwaitState(RobotState& state, backend::ReadRule rule) override {
    const Time limit = clock_.Now() + kLong;
    Time arrival{};
    while (backend().Read(rule, state, arrival) == backend::ReadResult::kPending) {
      if (!connection_.arrival->AwaitUntil(limit) && clock_.Now() >= limit) return false;
    }
    missed_in_row_ = std::max(missed_in_row_, state.message_id - last_id_ - 1);
    last_id_ = state.message_id;
    return arrival <= clock_.Now();
  }

  bool AwaitArrivals(int count) override {
    static_cast<void>(connection_.arrival->AwaitUntil(clock_.Now()));  // told of what was read
    for (int i = 0; i < count; ++i) {
      if (!connection_.arrival->AwaitUntil(clock_.Now() + kLong)) return false;
    }
    return true;
  }

  bool by_the_wall_clock() const override { return true; }
  bool disturbed() override {
    const bool missed_state = missed_in_row_ > 0;
    // A command that came too late is dropped one or two cycles on.
    RobotState state;
    for (int i = 0; i < 3; ++i) static_cast<void>(AwaitState(state, backend::ReadRule::kNewest));
    return missed_state || late_commands_.any();
  }
  std::uint64_t missed_in_row() const override { return missed_in_row_; }
  void ForgetDisturbances() override {
    missed_in_row_ = 0;
    late_commands_.Forget();
  }

 private:
  const UrgentHere urgent_;
  const MonotonicClock clock_;
  robot::RobotConfig config_;
  LateCommands late_commands_;
  backend::Connection connection_;
  std::uint64_t last_id_ = 0;
  std::uint64_t missed_in_row_ = 0;
};

}  // namespace

std::vector<HarnessCase> Harnesses() {
  const auto make = [](const robot::RobotConfig& robot) {
    return std::make_unique<RealtimeHarness>(robot);
  };
  return {{"MujocoPlantInRealtime", robot::PlantKind::kMujoco, make, false, kUrgentHere},
          {"IdealPlantInRealtime", robot::PlantKind::kIdeal, make, false, kUrgentHere}};
}

}  // namespace twin::test
