#include "twin/onboard/base_controller.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/husky.h"
#include "support/realtime_guard.h"
#include "twin/core/error.h"

namespace twin::onboard::onboard_base_controller_test {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// Four flywheels, each with a quarter of a vehicle on it.
class Flywheels {
 public:
  void Step(const WheelDrive& drive) {
    constexpr double kInertia = 0.9;  // kg m^2
    for (std::size_t i = 0; i < 4; ++i) {
      if (blocked) {
        sensors.dq[i] = 0;
        continue;
      }
      sensors.dq[i] += drive.tau[i] / kInertia * kCycleSeconds;
      sensors.q[i] += sensors.dq[i] * kCycleSeconds;
    }
  }
  WheelSensors sensors;
  bool blocked = false;
};

class BaseControllerTest : public ::testing::Test {
 protected:
  /// Runs cycles; the command comes anew in each of them.
  void Run(int cycles, const std::optional<BaseTwist>& command, bool emergency = false) {
    for (int k = 0; k < cycles; ++k) {
      last_ = controller_.state();
      drive_ = controller_.Cycle(wheels_.sensors, command, emergency);
      wheels_.Step(drive_);
      const BaseTwist& d = controller_.state().twist_d;
      fastest_dv_ = std::max(fastest_dv_, std::abs(d.v - last_.twist_d.v) / kCycleSeconds);
      fastest_dw_ = std::max(fastest_dw_, std::abs(d.w - last_.twist_d.w) / kCycleSeconds);
      for (const double tau : drive_.tau) most_tau_ = std::max(most_tau_, std::abs(tau));
    }
  }
  [[nodiscard]] const BaseState& state() const { return controller_.state(); }

  const BaseConfig config_ = test::HuskyConfig();
  Flywheels wheels_;
  BaseController controller_{config_, wheels_.sensors};
  BaseState last_;
  WheelDrive drive_;
  double fastest_dv_ = 0;
  double fastest_dw_ = 0;
  double most_tau_ = 0;
};

TEST_F(BaseControllerTest, StandsBeforeTheFirstCommand) {
  Run(100, std::nullopt);
  EXPECT_EQ(state().mode, BaseMode::kStanding);
  EXPECT_EQ(most_tau_, 0);
}

TEST_F(BaseControllerTest, CutsWhatIsTooFast) {
  Run(4000, BaseTwist{5, -9});
  EXPECT_EQ(state().twist_d, (BaseTwist{1, -2}));
}

TEST_F(BaseControllerTest, KeepsTheAccelerationsItMay) {
  Run(1000, BaseTwist{1, 2});
  Run(1000, BaseTwist{-1, -2});
  EXPECT_NEAR(fastest_dv_, config_.ordinary.dv, 1e-9);
  EXPECT_NEAR(fastest_dw_, config_.ordinary.dw, 1e-9);
}

TEST_F(BaseControllerTest, TurnsWheelsAsTheTwistAsks) {
  Run(6000, BaseTwist{0.3, 0.5});
  const double half = 1.805 * 0.5708 / 2;
  for (const std::size_t left : {0, 2}) {
    EXPECT_NEAR(wheels_.sensors.dq[left], (0.3 - 0.5 * half) / 0.1651, 1e-3);
    EXPECT_NEAR(wheels_.sensors.dq[left + 1], (0.3 + 0.5 * half) / 0.1651, 1e-3);
  }
}

TEST_F(BaseControllerTest, ReportsTheTwistOfItsWheels) {
  Run(6000, BaseTwist{0.3, 0.5});
  EXPECT_NEAR(state().twist.v, 0.3, 1e-3);
  EXPECT_NEAR(state().twist.w, 0.5, 1e-3);
}

TEST_F(BaseControllerTest, OdometryFollowsAnArc) {
  // Wheels that turn evenly: a quarter of a circle of 0.6 m to the left, from its own start.
  constexpr int kCycles = 1000;
  const double yaw = std::numbers::pi / 2;
  const double half = 1.805 * 0.5708 / 2;
  for (int k = 1; k <= kCycles; ++k) {
    for (std::size_t i = 0; i < 4; ++i) {
      const double way = yaw * (0.6 + (i % 2 == 0 ? -half : half));
      wheels_.sensors.q[i] = way / 0.1651 * k / kCycles;
    }
    (void)controller_.Cycle(wheels_.sensors, std::nullopt, false);
  }
  EXPECT_NEAR(state().odometry.x, 0.6, 1e-6);
  EXPECT_NEAR(state().odometry.y, 0.6, 1e-6);
  EXPECT_NEAR(state().odometry.yaw, yaw, 1e-9);
}

TEST_F(BaseControllerTest, OdometryBeginsWhereItIsSwitchedOn) {
  wheels_.sensors.q.fill(17);
  BaseController late(config_, wheels_.sensors);
  (void)late.Cycle(wheels_.sensors, std::nullopt, false);
  EXPECT_EQ(late.state().odometry, BasePose());
}

TEST_F(BaseControllerTest, ACommandCountsForItsWatchdogAndNoLonger) {
  Run(1, BaseTwist{0.5, 0});
  Run(199, std::nullopt);
  EXPECT_EQ(state().mode, BaseMode::kDriving);
  Run(1, std::nullopt);
  EXPECT_EQ(state().mode, BaseMode::kStanding);
}

TEST_F(BaseControllerTest, BrakesWithoutCommandsByItsOwnLimit) {
  Run(2000, BaseTwist{0.8, 0});
  fastest_dv_ = 0;
  Run(1100, std::nullopt);
  EXPECT_EQ(state().twist_d, BaseTwist());
  EXPECT_NEAR(fastest_dv_, config_.lost.dv, 1e-9);
}

TEST_F(BaseControllerTest, AnEmergencyStopBrakesFasterAndDropsCommands) {
  Run(2000, BaseTwist{0.9, 0});
  Run(301, BaseTwist{0.9, 0}, true);  // 0.9 / 3 s
  EXPECT_EQ(state().mode, BaseMode::kEmergencyStop);
  EXPECT_EQ(state().twist_d, BaseTwist());
}

TEST_F(BaseControllerTest, StandsAfterAnEmergencyStopUntilItIsCommanded) {
  Run(2000, BaseTwist{0.9, 0});
  Run(500, std::nullopt, true);
  Run(50, std::nullopt);
  EXPECT_EQ(state().mode, BaseMode::kStanding);
  Run(50, BaseTwist{0.2, 0});
  EXPECT_EQ(state().mode, BaseMode::kDriving);
}

TEST_F(BaseControllerTest, TakesWhatIsNotFiniteAsZero) {
  Run(2000, BaseTwist{kNaN, std::numeric_limits<double>::infinity()});
  EXPECT_EQ(state().twist_d, BaseTwist());
  EXPECT_EQ(most_tau_, 0);
}

TEST_F(BaseControllerTest, KeepsTheTorqueItMay) {
  wheels_.blocked = true;
  Run(5000, BaseTwist{1, 0});
  EXPECT_EQ(most_tau_, config_.tau_max);
}

TEST_F(BaseControllerTest, BlockedWheelsWindNothingUp) {
  wheels_.blocked = true;
  Run(20'000, BaseTwist{0.5, 0});
  wheels_.blocked = false;
  Run(1500, BaseTwist{0.5, 0});
  EXPECT_NEAR(state().twist.v, 0.5, 0.05) << "as long as any change of speed would take";
}

TEST_F(BaseControllerTest, RunsWithoutAllocationOrLock) {
  const test::RealtimeGuard guard;
  Run(500, BaseTwist{1, 1});
  Run(500, std::nullopt, true);
  const auto counts = guard.counts();
  EXPECT_EQ(counts, test::RealtimeGuard::Counts());
}

TEST(BaseConfigTest, NamesWhatIsWrong) {
  const auto text = [](auto change) -> std::string {
    BaseConfig config = test::HuskyConfig();
    change(config);
    try {
      config.Validate();
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(text([](BaseConfig&) {}), "");
  EXPECT_THAT(text([](BaseConfig& c) { c.track = 0; }), ::testing::HasSubstr("track is 0"));
  EXPECT_THAT(text([](BaseConfig& c) { c.track_factor = 0.5; }),
              ::testing::HasSubstr("track_factor is 0.5"));
  EXPECT_THAT(text([](BaseConfig& c) { c.lost.dw = kNaN; }), ::testing::HasSubstr("lost.dw"));
  EXPECT_THAT(text([](BaseConfig& c) { c.watchdog = Duration::zero(); }),
              ::testing::HasSubstr("watchdog"));
}

}  // namespace
}  // namespace twin::onboard::onboard_base_controller_test
