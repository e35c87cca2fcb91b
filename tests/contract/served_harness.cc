#include "contract/served_harness.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>

#include "contract/urgent.h"
#include "plugins/backends.h"
#include "twin/core/clock.h"
#include "twin/rt/host_time.h"
#include "twin/server/served_robot.h"

namespace twin::test {
namespace {

/// Longer than any machine holds up a thread.
constexpr Duration kLong = std::chrono::seconds(30);
/// In lockstep, a motion of a test that has failed need not be waited for.
constexpr Duration kAnswerTimeout = std::chrono::seconds(3);

/// What the robot itself saw.
class Witness final : public record::RecordSink {
 public:
  void Put(const record::CycleRecord& record) noexcept override {
    if (record.dropped > 0) late_commands_ = true;
    ++cycles_;
  }
  void Put(const record::TickRecord&) noexcept override {}

  [[nodiscard]] std::uint64_t cycles() const { return cycles_; }
  /// Whether a command came for a cycle that had passed.
  [[nodiscard]] bool late_commands() const { return late_commands_; }
  void Forget() { late_commands_ = false; }

 private:
  std::atomic<std::uint64_t> cycles_ = 0;
  std::atomic<bool> late_commands_ = false;
};

server::ServedRobotSettings SettingsOf(backend::RobotTime time, bool freeze,
                                       record::RecordSink& sink) {
  server::ServedRobotSettings settings{.takes_free_ports = true, .sink = &sink};
  const bool waits = time == backend::RobotTime::kStates;
  settings.thread = Urgent("robot", waits ? 0 : 85);
  if (waits) settings.lockstep = {.answer_timeout = kAnswerTimeout, .freeze_when_idle = freeze};
  return settings;
}

class ServedHarness final : public BackendHarness {
 public:
  ServedHarness(const robot::RobotConfig& robot, backend::RobotTime time, bool freeze)
      : time_(time), config_(robot) {
    if (time == backend::RobotTime::kWall) urgent_.emplace();
    config_.link.d_INT = Duration::zero();  // the whole period is there for the answer
    service_.emplace(config_, robot::MakePlant(config_), SettingsOf(time, freeze, witness_));
    service_->Start();
    connection_ = plugins::ConnectFci(
        {config_,
         backend::RemoteRobot{
             clock_, {.host = "127.0.0.1", .arm_port = service_->arm().port, .time = time}},
         nullptr});
  }

  backend::Backend& backend() override { return *connection_.backend; }
  backend::Hand* hand() override { return connection_.hand; }

  bool AwaitState(RobotState& state, backend::ReadRule rule) override {
    const Time limit = clock_.Now() + kLong;
    Time arrival{};
    while (true) {
      const backend::ReadResult result = backend().Read(rule, state, arrival);
      if (result == backend::ReadResult::kState) break;
      if (result == backend::ReadResult::kLost || clock_.Now() >= limit) return false;
      static_cast<void>(connection_.arrival->AwaitUntil(limit));
    }
    missed_in_row_ = std::max(missed_in_row_, state.message_id - last_id_ - 1);
    last_id_ = state.message_id;
    return arrival <= clock_.Now();
  }

  bool AwaitArrivals(int count) override {
    // A cycle that has been recorded has sent its state, but for the last.
    const std::uint64_t enough = witness_.cycles() + static_cast<std::uint64_t>(count) + 1;
    const Time limit = clock_.Now() + kLong;
    while (witness_.cycles() <= enough) {
      if (clock_.Now() >= limit) return false;
      rt::Pause(std::chrono::microseconds(200));
    }
    return true;
  }

  bool by_the_wall_clock() const override { return true; }
  bool recovers_at_rest() const override { return true; }
  bool disturbed() override {
    const bool missed_state = missed_in_row_ > 0;
    if (time_ == backend::RobotTime::kStates) return missed_state;  // it waits for answers
    // A command that came too late is dropped one or two cycles on.
    RobotState state;
    for (int i = 0; i < 3; ++i) static_cast<void>(AwaitState(state, backend::ReadRule::kNewest));
    return missed_state || witness_.late_commands();
  }
  std::uint64_t missed_in_row() const override { return missed_in_row_; }
  void ForgetDisturbances() override {
    missed_in_row_ = 0;
    witness_.Forget();
  }

 private:
  std::optional<UrgentHere> urgent_;
  const backend::RobotTime time_;
  const MonotonicClock clock_;
  robot::RobotConfig config_;
  Witness witness_;
  std::optional<server::ServedRobot> service_;
  backend::Connection connection_;
  std::uint64_t last_id_ = 0;
  std::uint64_t missed_in_row_ = 0;
};

}  // namespace

std::unique_ptr<BackendHarness> MakeServedHarness(const robot::RobotConfig& robot,
                                                  backend::RobotTime time, bool freeze) {
  return std::make_unique<ServedHarness>(robot, time, freeze);
}

}  // namespace twin::test
