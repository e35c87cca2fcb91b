#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "controllers/registration.h"
#include "plugins/backends.h"
#include "twin/core/error.h"
#include "twin/run/run.h"
#include "twin/run/session.h"

namespace twin::run::run_base_test {
namespace {

/// The arm held for four seconds on a base that drives 0.4 m ahead and turns a little.
scenario::Scenario Rolling() {
  return scenario::Parse(R"(name: rolling
base:
  start: {x: 0.2 m, y: 0.1 m, yaw: 0.3 rad}
  drive:
    - {at: 200 ms, for: 1 s, v: 0.4 m/s}
    - {at: 2.2 s, for: 800 ms, w: 0.5 rad/s}
motion:
  trajectory:
    unit: rad
    waypoints:
      - {q: [0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854], at: 0 s}
      - {q: [0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854], at: 4 s}
)",
                         "rolling.yaml");
}

/// The arm as a spring of 900 N/m, on a base that drives about as fast as it may.
scenario::Scenario SoftlyRolling() {
  return scenario::Parse(R"(name: softly_rolling
base:
  drive:
    - {at: 500 ms, for: 2.5 s, v: 1 m/s}
    - {at: 5 s, for: 2 s, v: -0.5 m/s, w: 0.8 rad/s}
onboard: {collision_behavior: off}
controller:
  type: compliance
  parameters:
    reference: hold
    stiffness: {translation: 900 N/m, rotation: 90 Nm/rad}
    damping: {translation: 100 Ns/m, rotation: 10 Nms/rad}
    k0: 0.3 Nm/rad
    q0: {unit: deg, values: [0, -45, 0, -135, 0, 90, 45]}
motion:
  interface: torque
  trajectory:
    unit: rad
    waypoints:
      - {q: [0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854], at: 0 s}
      - {q: [0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854], at: 8 s}
)",
                         "softly_rolling.yaml");
}

/// What the base was, cycle by cycle, and how far the arm went from where it began.
class Watch final : public record::RecordSink {
 public:
  void Put(const record::CycleRecord& record) noexcept override {
    if (record.base) states.push_back(*record.base);
    if (!first_) first_ = record.state.O_T_EE;
    double square = 0;
    for (std::size_t i = 12; i < 15; ++i) {
      square += std::pow(record.state.O_T_EE[i] - (*first_)[i], 2);
    }
    arm_way = std::max(arm_way, std::sqrt(square));
  }
  void Put(const record::TickRecord& /*record*/) noexcept override {}

  std::vector<BaseState> states;
  double arm_way = 0;  ///< in O, m

 private:
  std::optional<Transform> first_;
};

class BaseRunTest : public ::testing::Test {
 protected:
  BaseRunTest() {
    plugins::RegisterMujoco(backends_);
    controllers::RegisterControllers(controllers_);
  }
  [[nodiscard]] RunResult Execute(const scenario::Scenario& scenario,
                                  record::RecordSink* sink = nullptr) const {
    run::Run run(scenario, {backends_, controllers_}, files_, sink);
    return run.Execute();
  }

  backend::Registry backends_;
  control::ControllerRegistry controllers_;
  const RunFiles files_{std::filesystem::path(TWIN_SOURCE_DIR) / "models", {}, {}, false};
};

TEST_F(BaseRunTest, DrivesWhileTheArmIsHeld) {
  Watch watch;
  const RunResult result = Execute(Rolling(), &watch);
  EXPECT_EQ(result.report.end, backend::MotionEnd::kSuccess) << result.report.failure;
  ASSERT_TRUE(result.base.has_value());
  EXPECT_NEAR(result.base->odometry.x, 0.4, 0.01) << "where it was switched on";
  EXPECT_NEAR(result.base->odometry.yaw, 0.4, 0.02);
  EXPECT_LT(watch.arm_way, 0.01);
}

TEST_F(BaseRunTest, ASoftArmKeepsItsPlaceOnItWithinACentimetre) {
  Watch watch;
  const RunResult result = Execute(SoftlyRolling(), &watch);
  EXPECT_EQ(result.report.end, backend::MotionEnd::kSuccess) << result.report.failure;
  EXPECT_GT(watch.arm_way, 0.002) << "it does swing";
  EXPECT_LT(watch.arm_way, 0.01);
}

TEST_F(BaseRunTest, RecordsTheBaseInEveryCycle) {
  Watch watch;
  const RunResult result = Execute(Rolling(), &watch);
  ASSERT_GE(watch.states.size(), 4000u);
  for (std::size_t k = 0; k < watch.states.size(); ++k) {
    ASSERT_EQ(watch.states[k].message_id, k + 1);
  }
}

TEST_F(BaseRunTest, RepeatsToTheBit) {
  EXPECT_EQ(Execute(Rolling()).states_hash, Execute(Rolling()).states_hash);
}

TEST_F(BaseRunTest, WhatTheBaseDoesIsInTheHash) {
  scenario::Scenario other = Rolling();
  other.base->drive.pop_back();
  EXPECT_NE(Execute(Rolling()).states_hash, Execute(other).states_hash);
}

TEST_F(BaseRunTest, RefusesADriveBehindTheMotion) {
  scenario::Scenario scenario = Rolling();
  scenario.base->drive.back().at = std::chrono::seconds(4);
  EXPECT_THAT([&] { (void)Execute(scenario); },
              ::testing::ThrowsMessage<InputError>(
                  ::testing::HasSubstr("base.drive[2].at: 4 s is not before the end")));
}

TEST_F(BaseRunTest, ASessionOffersItsBase) {
  scenario::Scenario scenario = Rolling();
  scenario.base->drive.clear();
  Session session(scenario, {backends_, controllers_}, files_, nullptr);
  ASSERT_NE(session.base(), nullptr);
  session.Begin();
  for (int k = 0; k < 20; ++k) {
    session.base()->Drive({0.3, 0});
    EXPECT_EQ(session.Wait(std::chrono::milliseconds(50), [](const RobotState&) { return false; }),
              WaitEnd::kTimeLimit);
  }
  EXPECT_EQ(session.base()->ReadState().mode, BaseMode::kDriving);
  EXPECT_NEAR(session.base()->ReadState().twist.v, 0.3, 0.01);
  (void)session.End();
}

TEST_F(BaseRunTest, WithoutABaseThereIsNone) {
  scenario::Scenario scenario = Rolling();
  scenario.base.reset();
  Session session(scenario, {backends_, controllers_}, files_, nullptr);
  EXPECT_EQ(session.base(), nullptr);
}

}  // namespace
}  // namespace twin::run::run_base_test
