#include "twin/loop/controller_loop.h"

#include <chrono>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

namespace twin::loop::loop_controller_loop_test {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;

/// Moves joint 1 at 1 rad/s of the loop's own time.
class Ramp final : public control::Controller {
 public:
  control::CommandInterface command_interface() const noexcept override {
    return control::CommandInterface::kJointPosition;
  }
  void Activate(const RobotState&, Time) override {}
  void Update(const RobotState&, Time now, control::ControllerOutput& output) noexcept override {
    updates.push_back(now);
    output.target.joint.q[0] = ToSeconds(now.time_since_epoch());
    output.fresh = fresh;
    output.sampled_at = sampled_at;
    output.finished = finished;
  }
  void Deactivate() noexcept override {}

  std::vector<Time> updates;
  bool fresh = true;
  bool finished = false;
  std::optional<Time> sampled_at;
};

class ControllerLoopTest : public ::testing::Test {
 protected:
  /// Wakes `loop` n times by its own schedule; returns when.
  std::vector<Time> Run(ControllerLoop& loop, int n) {
    PublishedState published;
    published.state.message_id = 17;
    exchange_.states.Publish(published);
    std::vector<Time> wakes;
    Time at = loop.Start(Time(milliseconds(100)));
    for (int i = 0; i < n; ++i) {
      wakes.push_back(at);
      EXPECT_TRUE(loop.OnWake(at));
      at = loop.OnDone(at + loop.cost());
    }
    return wakes;
  }

  ControllerLoopConfig config_;
  Ramp ramp_;
  Exchange exchange_;
};

TEST_F(ControllerLoopTest, WakesOnItsOwnGrid) {
  config_.rate_hz = 125;
  config_.phase = microseconds(300);
  ControllerLoop loop(config_, ramp_, exchange_, 1);
  const std::vector<Time> wakes = Run(loop, 3);
  EXPECT_EQ(wakes[0], Time(milliseconds(100) + microseconds(300)));
  EXPECT_EQ(wakes[1] - wakes[0], milliseconds(8));
  EXPECT_EQ(wakes[2] - wakes[1], milliseconds(8));
}

TEST_F(ControllerLoopTest, AFastClockShortensItsPeriodAndSeesItsOwnTime) {
  config_.clock_ppm = 1000;
  ControllerLoop loop(config_, ramp_, exchange_, 1);
  const std::vector<Time> wakes = Run(loop, 2);
  EXPECT_EQ(wakes[1] - wakes[0], FromSeconds(1e-3 / 1.001));
  EXPECT_NEAR(ToSeconds(ramp_.updates[1] - ramp_.updates[0]), 1e-3, 2e-9);
}

TEST_F(ControllerLoopTest, AnOverrunSkipsToTheGrid) {
  config_.cost = faults::DelayModel(faults::ConstantDelay{microseconds(2500)});
  ControllerLoop loop(config_, ramp_, exchange_, 1);
  const std::vector<Time> wakes = Run(loop, 3);
  EXPECT_EQ(wakes[1] - wakes[0], milliseconds(3));
  EXPECT_EQ(wakes[2] - wakes[1], milliseconds(3));
  EXPECT_EQ(loop.overruns(), 6u);
}

TEST_F(ControllerLoopTest, DepositsNothingUntilTheSourceHasGivenSomethingNew) {
  ControllerLoop loop(config_, ramp_, exchange_, 1);
  ramp_.fresh = false;
  Run(loop, 3);
  EXPECT_FALSE(exchange_.deposits.Refresh());
  ramp_.finished = true;  // the end is always told
  Run(loop, 1);
  EXPECT_TRUE(exchange_.deposits.Refresh());
}

TEST_F(ControllerLoopTest, ADepositHasTheTimeAtWhichItsSourceSampled) {
  ControllerLoop loop(config_, ramp_, exchange_, 1);
  ramp_.sampled_at = Time(milliseconds(42));
  Run(loop, 1);
  ASSERT_TRUE(exchange_.deposits.Refresh());
  EXPECT_EQ(exchange_.deposits.value().source_time, Time(milliseconds(42)));
}

TEST_F(ControllerLoopTest, FormsTheVelocityAtTheDepositOverItsOwnElapsedTime) {
  config_.wake_delay = faults::DelayModel(faults::LogNormalDelay{microseconds(50), 0.8, {}});
  ControllerLoop loop(config_, ramp_, exchange_, 5);
  Run(loop, 20);
  ASSERT_TRUE(exchange_.deposits.Refresh());
  const Deposit& deposit = exchange_.deposits.value();
  EXPECT_NEAR(deposit.target.joint.dq[0], 1.0, 1e-9)
      << "jittered wake-ups, yet the ramp's own speed";
  EXPECT_EQ(deposit.based_on, 17u);
}

TEST_F(ControllerLoopTest, DoesNothingBeforeAStateWasPublished) {
  ControllerLoop loop(config_, ramp_, exchange_, 1);
  const Time first = loop.Start({});
  EXPECT_FALSE(loop.OnWake(first));
  EXPECT_EQ(loop.NextWake(first), first + kCycle);
  EXPECT_TRUE(ramp_.updates.empty());
}

}  // namespace
}  // namespace twin::loop::loop_controller_loop_test
