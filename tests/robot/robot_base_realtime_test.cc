// The seam to a mobile base on the wall clock: requests and states cross threads while the robot's
// own runs. Nothing here depends on the machine being fast.

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "robot/robot_fixture.h"
#include "support/husky.h"
#include "twin/robot/realtime_robot.h"
#include "twin/rt/host_time.h"

namespace twin::robot::robot_base_realtime_test {
namespace {

using std::chrono::microseconds;

/// Wheels that follow their drives as flywheels.
class Flywheels final : public plant::BaseBody {
 public:
  void Drive(const WheelDrive& drive) noexcept override { drive_ = drive; }
  [[nodiscard]] const WheelSensors& sensors() const noexcept override { return sensors_; }
  void Step() noexcept {
    constexpr double kInertia = 0.9;  // kg m^2
    for (std::size_t i = 0; i < 4; ++i) {
      sensors_.dq[i] += drive_.tau[i] / kInertia * kCycleSeconds;
      sensors_.q[i] += sensors_.dq[i] * kCycleSeconds;
    }
  }

 private:
  WheelDrive drive_;
  WheelSensors sensors_;
};

/// An ideal arm on them: cheap enough for the wall clock under a sanitizer.
class RollingPlant final : public plant::Plant {
 public:
  void Reset(const JointVector& q) override { arm_.Reset(q); }
  std::unique_ptr<const State> Save() const override { return arm_.Save(); }
  void Restore(const State& state) override { arm_.Restore(state); }
  void Step(const JointDrive& drive) noexcept override {
    arm_.Step(drive);
    wheels_.Step();
  }
  [[nodiscard]] const JointSensors& sensors() const noexcept override { return arm_.sensors(); }
  [[nodiscard]] plant::BaseBody* base() noexcept override { return &wheels_; }

 private:
  plant::IdealPlant arm_;
  Flywheels wheels_;
};

class RobotBaseRealtimeTest : public ::testing::Test {
 protected:
  RobotBaseRealtimeTest() {
    RobotConfig config = test::PandaRobot();
    config.base = test::HuskyConfig();
    rt::ThreadSettings thread;
    thread.name = "robot";
    thread.lock_memory = false;
    robot_ = std::make_unique<RealtimeRobot>(config, std::make_unique<RollingPlant>(), clock_,
                                             thread, nullptr);
  }
  [[nodiscard]] BaseUnit& base() { return *robot_->base(); }
  void Pause() { rt::SleepUntil(clock_, clock_.Now() + microseconds(200)); }
  /// Drives until `done` says so of a state.
  template <typename Done>
  void DriveUntil(const BaseTwist& twist, Done done) {
    while (!done(base().ReadState())) {
      base().Drive(twist);
      Pause();
    }
  }

  const MonotonicClock clock_;
  std::unique_ptr<RealtimeRobot> robot_;
};

TEST_F(RobotBaseRealtimeTest, FollowsWhatAnotherThreadAsks) {
  robot_->Begin();
  DriveUntil({0.1, 0}, [](const BaseState& state) { return state.twist.v > 0.099; });
  EXPECT_EQ(base().ReadState().mode, BaseMode::kDriving);
  robot_->End();
}

TEST_F(RobotBaseRealtimeTest, StandsWhenNobodyAsks) {
  robot_->Begin();
  DriveUntil({0.1, 0}, [](const BaseState& state) { return state.twist_d.v > 0.05; });
  while (base().ReadState().mode != BaseMode::kStanding) Pause();
  while (base().ReadState().twist_d.v > 0) Pause();
  robot_->End();
}

TEST_F(RobotBaseRealtimeTest, AnyThreadMayStopAndAnySees) {
  robot_->Begin();
  std::atomic<bool> over{false};
  std::atomic<int> backwards{0};
  std::vector<std::jthread> others;
  others.reserve(3);
  for (int i = 0; i < 2; ++i) {
    others.emplace_back([&] {
      std::uint64_t seen = 0;
      while (!over) {
        const std::uint64_t id = base().ReadState().message_id;
        if (id < seen) ++backwards;
        seen = id;
        std::this_thread::yield();
      }
    });
  }
  others.emplace_back([&] {
    while (!over) {
      base().EmergencyStop();
      Pause();
      base().Release();
      Pause();
    }
  });
  DriveUntil({0.2, 0.3}, [](const BaseState& state) { return state.message_id > 500; });
  over = true;
  others.clear();
  base().EmergencyStop();
  while (base().ReadState().mode != BaseMode::kEmergencyStop) Pause();
  robot_->End();
  EXPECT_EQ(backwards, 0);
}

}  // namespace
}  // namespace twin::robot::robot_base_realtime_test
