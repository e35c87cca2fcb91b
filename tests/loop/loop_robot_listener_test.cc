#include "twin/loop/robot_listener.h"

#include <chrono>
#include <cstdint>

#include <gtest/gtest.h>

#include "twin/core/clock.h"
#include "twin/rt/host_time.h"
#include "twin/rt/signal.h"

namespace twin::loop::loop_robot_listener_test {
namespace {

using std::chrono::milliseconds;

/// Gives a state whenever it is asked, so that nothing depends on how fast this machine is; every
/// tenth id is missing.
class Talker final : public backend::Backend, public rt::Arrival {
 public:
  explicit Talker(const MonotonicClock& clock) : clock_(clock) {}

  [[nodiscard]] backend::Description Describe() const override { return {}; }
  void Configure(const Setting&) override { ++spoken_to; }
  void Start(const MotionModes&) override { ++spoken_to; }
  backend::ReadResult Read(backend::ReadRule rule, RobotState& state,
                           Time& arrival) noexcept override {
    if (gone) return backend::ReadResult::kLost;
    if (mute || (rule == backend::ReadRule::kFresh && first_)) {
      first_ = false;
      return backend::ReadResult::kPending;
    }
    id_ += id_ % 10 == 9 ? 2 : 1;
    state.message_id = id_;
    arrival = clock_.Now();
    rt::SleepUntil(clock_, clock_.Now() + milliseconds(1));
    return backend::ReadResult::kState;
  }
  void Write(const RobotCommand&) noexcept override { ++spoken_to; }
  void Stop() override { ++spoken_to; }
  void Recover() override { ++spoken_to; }
  bool AwaitUntil(Time deadline) noexcept override {
    if (mute) rt::SleepUntil(clock_, deadline);
    return !mute;
  }

  bool mute = false;
  bool gone = false;
  int spoken_to = 0;

 private:
  const MonotonicClock& clock_;
  bool first_ = true;
  std::uint64_t id_ = 0;
};

class RobotListenerTest : public ::testing::Test {
 protected:
  ListenReport Listen() {
    ListenSettings settings;
    settings.span = milliseconds(100);
    settings.tolerance = std::chrono::seconds(1);
    settings.thread.name = "listener";
    settings.thread.lock_memory = false;
    return ListenToRobot(clock_, robot_, robot_, settings);
  }
  MonotonicClock clock_;
  Talker robot_{clock_};
};

TEST_F(RobotListenerTest, CountsStatesAndThoseThatWereLost) {
  const ListenReport report = Listen();
  EXPECT_GT(report.states, 1u);
  EXPECT_EQ(report.last.message_id, report.states + report.lost);
  EXPECT_EQ(report.lost, report.last.message_id / 10);
  EXPECT_EQ(report.deviation.count(), report.states - 1);
}

TEST_F(RobotListenerTest, SuccessIsTheShareOfCyclesThatCouldHaveBeenAnswered) {
  const ListenReport report = Listen();
  EXPECT_EQ(report.in_time, report.states - 1 - report.lost) << "the tolerance takes any delay";
  EXPECT_DOUBLE_EQ(report.success_rate(), static_cast<double>(report.in_time) /
                                              static_cast<double>(report.last.message_id - 1));
}

TEST_F(RobotListenerTest, SendsNothing) {
  static_cast<void>(Listen());
  EXPECT_EQ(robot_.spoken_to, 0);
}

TEST_F(RobotListenerTest, GivesUpARobotThatSaysNothing) {
  robot_.mute = true;
  const ListenReport report = Listen();
  EXPECT_EQ(report.states, 0u);
  EXPECT_EQ(report.success_rate(), 0);
  EXPECT_EQ(report.rate_hz, 0);
}

TEST_F(RobotListenerTest, GivesUpAConnectionThatIsGone) {
  robot_.gone = true;
  EXPECT_EQ(Listen().states, 0u);
}

}  // namespace
}  // namespace twin::loop::loop_robot_listener_test
