#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "application/home_motion.h"
#include "run/session_fixture.h"
#include "twin/core/error.h"

namespace twin::application::application_home_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

/// The hand around the box of scenes/table_box.xml, as in models/scenarios/grasp.yaml.
constexpr const char* kAtBox = "[0, -0.13681, 0, -2.23480, 0, 2.09800, -0.78540]";
constexpr const char* kReady = "[0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]";
constexpr double kTurn = 0.5;  // rad, of joint 1, from kReady home
constexpr double kReach = 0.307;
constexpr double kHeight = 0.487;  // m: the end effector at kReady

/// Beside a table with a box, at rest.
scenario::Scenario At(const std::string& q) {
  return scenario::Parse(
      "name: home\nscene: scenes/table_box.xml\nmotion:\n  trajectory:\n    unit: "
      "rad\n    waypoints:\n      - {at: 0 s, q: " +
          q + "}\n      - {at: 1 s, q: " + q + "}\n",
      "home.yaml");
}

class HomeTest : public test::SessionFixture {
 protected:
  /// The way home of an arm at kReady, with the box at `p_W`.
  void GoHome(const Vector3& p_W) {
    const scenario::Scenario served = At(kReady);
    scenario::Scenario led = served;
    led.robot.q_start = home_;
    session_ = Open(served);
    session_->Begin();
    MoveHome(*session_, led, served, files_, [&](planning::CollisionWorld& world) {
      Transform X_WB = kIdentityTransform;
      for (std::size_t i = 0; i < p_W.size(); ++i) X_WB[12 + i] = p_W[i];
      world.Place("box", X_WB);
    });
  }

  const JointVector home_{kTurn, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854};
  std::unique_ptr<run::Session> session_;
};

TEST_F(HomeTest, ArmArrivesAtItsStartSlowly) {
  GoHome({0.5, 0, 0.325});
  const double tenth = 0.1 * session_->robot().limits.dq_max[0];
  EXPECT_GE(ToSeconds(session_->Now().time_since_epoch()), kTurn / tenth);
  EXPECT_EQ(session_->WaitForRest(), run::WaitEnd::kDone);
  const RobotState state = session_->ReadState();
  for (std::size_t i = 0; i < kJoints; ++i) EXPECT_NEAR(state.q[i], home_[i], 2e-3) << i;
}

TEST_F(HomeTest, FreeBodiesAreAvoidedWhereTheyAre) {
  const Vector3 in_the_hand{kReach * std::cos(kTurn), kReach * std::sin(kTurn), kHeight};
  EXPECT_THAT([&] { GoHome(in_the_hand); },
              ThrowsMessage<RobotFault>(AllOf(HasSubstr("no way home"), HasSubstr("box"))));
}

TEST_F(HomeTest, HandThatHoldsSomethingIsRefused) {
  const scenario::Scenario served = At(kAtBox);
  scenario::Scenario led = served;
  led.robot.q_start = home_;
  const auto session = Open(served);
  session->Begin();
  ASSERT_EQ(session->Command(hand::Move{.width = 0.075, .speed = 0.1}).result,
            HandResult::kSuccess);
  ASSERT_EQ(session->Command(hand::Grasp{.width = 0.05, .speed = 0.05, .force = 40}).result,
            HandResult::kSuccess);
  EXPECT_THAT([&] { MoveHome(*session, led, served, files_, [](planning::CollisionWorld&) {}); },
              ThrowsMessage<RobotFault>(HasSubstr("the hand holds something")));
}

}  // namespace
}  // namespace twin::application::application_home_test
