#include "twin/onboard/gripper.h"

#include <cmath>
#include <limits>
#include <optional>

#include <gtest/gtest.h>

#include "support/realtime_guard.h"
#include "twin/core/time.h"

namespace twin::onboard::onboard_gripper_test {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// A hand by another law than the plant's: one mass of 1 kg on a line, with stiff springs for its
/// stops and for an object between the fingers or, hollow, around them.
class SpringHand {
 public:
  explicit SpringHand(double opening) : x_(opening / 2) {}

  void Put(double width) { between_ = width; }
  void PutAround(double width) { around_ = width; }
  void TakeAway() {
    between_.reset();
    around_.reset();
  }
  void Close(double width) { x_ = width / 2; }

  void Step(const HandDrive& drive) {
    constexpr int kParts = 20;
    double pressed = 0;
    for (int part = 0; part < kParts; ++part) {
      const double resistance = Resistance();
      dx_ += (drive.force - 10 * dx_ + resistance) * kCycleSeconds / kParts;
      x_ += dx_ * kCycleSeconds / kParts;
      pressed -= resistance / kParts;
    }
    force_ = pressed;
  }
  [[nodiscard]] HandSensors sensors() const {
    return {.width = 2 * x_, .dwidth = 2 * dx_, .force = force_};
  }

 private:
  [[nodiscard]] double Resistance() const {
    const double least = between_.value_or(0) / 2;
    const double most = around_.value_or(kHandStroke) / 2;
    if (x_ < least) return 1e6 * (least - x_) - 2000 * dx_;
    if (x_ > most) return 1e6 * (most - x_) - 2000 * dx_;
    return 0;
  }

  double x_;
  double dx_ = 0;
  double force_ = 0;
  std::optional<double> between_;
  std::optional<double> around_;
};

class GripperTest : public testing::Test {
 protected:
  void Cycle(int cycles = 1) {
    for (int k = 0; k < cycles; ++k) {
      drive_ = gripper_.Cycle(hand_.sensors());
      hand_.Step(drive_);
    }
  }

  /// @returns how the command ended, and fails the test when it has not within 10 s.
  HandResult Run(const HandCommand& command) {
    const HandTicket ticket = gripper_.Start(command).ticket;
    EXPECT_NE(ticket, 0u);
    for (cycles_ = 0; cycles_ < 10'000; ++cycles_) {
      if (const auto result = gripper_.Outcome(ticket)) return *result;
      Cycle();
    }
    ADD_FAILURE() << twin::Name(command) << " does not end";
    return HandResult::kFail;
  }

  [[nodiscard]] const HandState& state() const { return gripper_.state(); }

  SpringHand hand_{0.03};
  Gripper gripper_{hand_.sensors()};
  HandDrive drive_;
  int cycles_ = 0;
};

TEST_F(GripperTest, HoldsItsOpeningUntilToldOtherwise) {
  Cycle(500);
  EXPECT_NEAR(state().width, 0.03, 1e-5);
  EXPECT_EQ(state().max_width, 0);
  EXPECT_FALSE(state().is_grasped);
  EXPECT_EQ(state().message_id, 500u);
}

TEST_F(GripperTest, HomingMeasuresTheLargestOpeningAndEndsOpen) {
  EXPECT_EQ(Run(hand::Homing{}), HandResult::kSuccess);
  EXPECT_NEAR(state().max_width, kHandStroke, 1e-4);
  Cycle(500);
  EXPECT_NEAR(state().width, kHandStroke, 1e-4);
  EXPECT_FALSE(state().is_grasped);
}

TEST_F(GripperTest, HomingFailsOnAnObjectAndForgetsNothing) {
  ASSERT_EQ(Run(hand::Homing{}), HandResult::kSuccess);
  const double max_width = state().max_width;
  hand_.Put(0.02);
  EXPECT_EQ(Run(hand::Homing{}), HandResult::kFail);
  EXPECT_EQ(state().max_width, max_width);
}

class GripperMoveTest : public GripperTest, public testing::WithParamInterface<double> {};

TEST_P(GripperMoveTest, ArrivesAtTheCommandedSpeed) {
  const double speed = GetParam();
  for (const double width : {0.0, 0.0153, 0.08}) {
    const double way = std::abs(width - hand_.sensors().width);
    EXPECT_EQ(Run(hand::Move{width, speed}), HandResult::kSuccess) << width;
    EXPECT_NEAR(state().width, width, 0.2e-3);
    EXPECT_NEAR(cycles_ * kCycleSeconds, way / std::min(speed, 0.1), 0.1) << width;
    Cycle(300);
    EXPECT_NEAR(state().width, width, 2e-5);
  }
}

INSTANTIATE_TEST_SUITE_P(Speeds, GripperMoveTest, testing::Values(0.01, 0.05, 0.1, 0.3));

TEST_F(GripperTest, MoveFailsHalfASecondAfterSomethingIsInTheWay) {
  hand_.Close(0.08);
  Cycle();
  hand_.Put(0.05);
  EXPECT_EQ(Run(hand::Move{0.01, 0.1}), HandResult::kFail);
  EXPECT_NEAR(cycles_, 300 + 500, 60);
  Cycle(200);
  EXPECT_NEAR(hand_.sensors().force, 0, 0.2);
}

TEST_F(GripperTest, GraspSucceedsOnAnObjectOfThatWidthAndPresses) {
  for (const double force : {1.0, 20.0, 70.0, 140.0}) {
    hand_.TakeAway();
    ASSERT_EQ(Run(hand::Move{0.08, 0.1}), HandResult::kSuccess);
    hand_.Put(0.05);
    EXPECT_EQ(Run(hand::Grasp{.width = 0.05, .speed = 0.1, .force = force}), HandResult::kSuccess);
    EXPECT_TRUE(state().is_grasped);
    Cycle(1000);
    EXPECT_TRUE(state().is_grasped);
    EXPECT_NEAR(hand_.sensors().force, -force, 0.01 * force);
  }
}

// The law is strict on both sides: width - inner < opening < width + outer. The object gives way
// by 20 um under 20 N.
TEST_F(GripperTest, GraspIsOneOnlyInsideItsBand) {
  const auto grasp = [this](double width, double inner, double outer) {
    hand_.TakeAway();
    EXPECT_EQ(Run(hand::Move{0.08, 0.1}), HandResult::kSuccess);
    hand_.Put(0.05);
    const HandResult result = Run(hand::Grasp{
        .width = width, .speed = 0.1, .force = 20, .epsilon_inner = inner, .epsilon_outer = outer});
    EXPECT_EQ(state().is_grasped, result == HandResult::kSuccess);
    EXPECT_NEAR(hand_.sensors().force, -20, 0.2);  // pressed all the same
    return result;
  };
  EXPECT_EQ(grasp(0.0545, 0.005, 0.005), HandResult::kSuccess);
  EXPECT_EQ(grasp(0.0555, 0.005, 0.005), HandResult::kUnsuccessful);
  EXPECT_EQ(grasp(0.0455, 0.005, 0.005), HandResult::kSuccess);
  EXPECT_EQ(grasp(0.0445, 0.005, 0.005), HandResult::kUnsuccessful);
  EXPECT_EQ(grasp(0.0445, 0.005, 0.006), HandResult::kSuccess);
  EXPECT_EQ(grasp(0.02, 0, 0.08), HandResult::kSuccess);
}

TEST_F(GripperTest, GraspThatMeetsNothingIsUnsuccessful) {
  ASSERT_EQ(Run(hand::Move{0.08, 0.1}), HandResult::kSuccess);
  EXPECT_EQ(Run(hand::Grasp{.width = 0.05, .speed = 0.05, .force = 20}), HandResult::kUnsuccessful);
  EXPECT_FALSE(state().is_grasped);
  EXPECT_LT(state().width, 1e-3);
}

TEST_F(GripperTest, BandThatIncludesZeroIsSatisfiedByNothing) {
  EXPECT_EQ(Run(hand::Grasp{.width = 0, .speed = 0.05, .force = 20, .epsilon_outer = 0.08}),
            HandResult::kSuccess);
  EXPECT_TRUE(state().is_grasped);
}

TEST_F(GripperTest, GraspFromWithinOpens) {
  hand_.Close(0.02);
  Cycle();
  hand_.PutAround(0.06);
  EXPECT_EQ(Run(hand::Grasp{.width = 0.06, .speed = 0.05, .force = 30}), HandResult::kSuccess);
  EXPECT_TRUE(state().is_grasped);
  Cycle(200);
  EXPECT_NEAR(hand_.sensors().force, 30, 0.3);
}

TEST_F(GripperTest, GraspWhileGraspingIsAnotherGrasp) {
  hand_.Close(0.08);
  Cycle();
  hand_.Put(0.05);
  ASSERT_EQ(Run(hand::Grasp{.width = 0.05, .speed = 0.1, .force = 20}), HandResult::kSuccess);
  EXPECT_EQ(Run(hand::Grasp{.width = 0.05, .speed = 0.1, .force = 40}), HandResult::kSuccess);
  Cycle(200);
  EXPECT_NEAR(hand_.sensors().force, -40, 0.4);
  EXPECT_TRUE(state().is_grasped);
}

TEST_F(GripperTest, LostObjectIsNoLongerGraspedAndTheFingersDoNotRace) {
  hand_.Close(0.08);
  Cycle();
  hand_.Put(0.05);
  ASSERT_EQ(Run(hand::Grasp{.width = 0.05, .speed = 0.1, .force = 70}), HandResult::kSuccess);
  hand_.TakeAway();
  double fastest = 0;
  int held_for = 0;
  for (int k = 0; k < 1000; ++k) {
    Cycle();
    held_for += state().is_grasped;
    fastest = std::max(fastest, -hand_.sensors().dwidth);
  }
  EXPECT_LT(held_for, 50);
  EXPECT_FALSE(state().is_grasped);
  EXPECT_LT(fastest, 0.31);  // both fingers at the speed where the drive gives no force
  EXPECT_LT(state().width, 1e-3);
}

TEST_F(GripperTest, StopAbortsWhatRuns) {
  const HandTicket move = gripper_.Start(hand::Move{0.08, 0.05}).ticket;
  Cycle(200);
  EXPECT_FALSE(gripper_.Outcome(move).has_value());
  EXPECT_EQ(Run(hand::Stop{}), HandResult::kSuccess);
  EXPECT_EQ(cycles_, 0);
  EXPECT_EQ(gripper_.Outcome(move), HandResult::kAborted);
  Cycle(300);
  const double width = state().width;
  EXPECT_NEAR(width, 0.04, 2e-3);
  Cycle(1000);
  EXPECT_NEAR(state().width, width, 1e-4);
}

TEST_F(GripperTest, StopReleasesTheForceOfAGrasp) {
  hand_.Close(0.08);
  Cycle();
  hand_.Put(0.05);
  ASSERT_EQ(Run(hand::Grasp{.width = 0.05, .speed = 0.1, .force = 40}), HandResult::kSuccess);
  EXPECT_EQ(Run(hand::Stop{}), HandResult::kSuccess);
  Cycle();
  EXPECT_FALSE(state().is_grasped);
  Cycle(200);
  EXPECT_NEAR(hand_.sensors().force, 0, 0.05);
  EXPECT_NEAR(state().width, 0.05, 2e-3);
}

TEST_F(GripperTest, MoveReleasesAnObject) {
  hand_.Close(0.08);
  Cycle();
  hand_.Put(0.05);
  ASSERT_EQ(Run(hand::Grasp{.width = 0.05, .speed = 0.1, .force = 40}), HandResult::kSuccess);
  EXPECT_EQ(Run(hand::Move{0.07, 0.1}), HandResult::kSuccess);
  EXPECT_FALSE(state().is_grasped);
}

TEST_F(GripperTest, ANewCommandAbortsTheOneThatRuns) {
  const HandTicket first = gripper_.Start(hand::Homing{}).ticket;
  Cycle(100);
  const HandTicket second = gripper_.Start(hand::Move{0.05, 0.1}).ticket;
  EXPECT_EQ(gripper_.Outcome(first), HandResult::kAborted);
  EXPECT_FALSE(gripper_.Outcome(second).has_value());
  Cycle(1000);
  EXPECT_EQ(gripper_.Outcome(second), HandResult::kSuccess);
}

TEST_F(GripperTest, RemembersTheLastEight) {
  EXPECT_FALSE(gripper_.Outcome(0).has_value());
  EXPECT_FALSE(gripper_.Outcome(1).has_value());
  for (int i = 0; i < 9; ++i) EXPECT_EQ(Run(hand::Stop{}), HandResult::kSuccess);
  EXPECT_EQ(gripper_.Outcome(1), HandResult::kAborted);
  for (HandTicket ticket = 2; ticket <= 9; ++ticket) {
    EXPECT_EQ(gripper_.Outcome(ticket), HandResult::kSuccess);
  }
  EXPECT_FALSE(gripper_.Outcome(10).has_value());
}

TEST_F(GripperTest, RefusesBadValuesAndWhatRunsGoesOn) {
  const HandTicket move = gripper_.Start(hand::Move{0.06, 0.1}).ticket;
  const auto field = [this](const HandCommand& command) {
    const HandStart start = gripper_.Start(command);
    EXPECT_EQ(start.ticket, 0u);
    return start.bad ? start.bad->field : "none";
  };
  const auto grasp = [](double width, double speed, double force, double inner, double outer) {
    return hand::Grasp{width, speed, force, inner, outer};
  };
  for (const double width : {-0.001, 0.0811, kNaN, kInfinity}) {
    EXPECT_EQ(field(hand::Move{width, 0.1}), "width");
    EXPECT_EQ(field(grasp(width, 0.1, 20, 0, 0)), "width");
  }
  for (const double speed : {0.0, -0.1, kNaN, kInfinity}) {
    EXPECT_EQ(field(hand::Move{0.05, speed}), "speed");
    EXPECT_EQ(field(grasp(0.05, speed, 20, 0, 0)), "speed");
  }
  for (const double force : {0.0, -20.0, 140.1, kNaN}) {
    EXPECT_EQ(field(grasp(0.05, 0.1, force, 0, 0)), "force");
  }
  for (const double epsilon : {-1e-9, kNaN, kInfinity}) {
    EXPECT_EQ(field(grasp(0.05, 0.1, 20, epsilon, 0)), "epsilon_inner");
    EXPECT_EQ(field(grasp(0.05, 0.1, 20, 0, epsilon)), "epsilon_outer");
  }
  Cycle(1000);
  EXPECT_EQ(gripper_.Outcome(move), HandResult::kSuccess);
}

TEST_F(GripperTest, WidthsUpToAMillimetreAboveTheLargestOpeningMeanIt) {
  ASSERT_EQ(Run(hand::Homing{}), HandResult::kSuccess);
  EXPECT_EQ(Run(hand::Move{state().max_width + 0.9e-3, 0.1}), HandResult::kSuccess);
  EXPECT_EQ(gripper_.Start(hand::Move{state().max_width + 1.1e-3, 0.1}).ticket, 0u);
}

// T = 25 + 25 (f / 70)^2 (1 - exp(-t / 300 s)).
TEST_F(GripperTest, TemperatureFollowsItsLaw) {
  EXPECT_EQ(state().temperature, 25);
  hand_.Close(0.08);
  Cycle();
  hand_.Put(0.05);
  ASSERT_EQ(Run(hand::Grasp{.width = 0.05, .speed = 0.1, .force = 140}), HandResult::kSuccess);
  Cycle(150'000);
  EXPECT_NEAR(state().temperature, 25 + 100 * (1 - std::exp(-0.5)), 1);
}

TEST_F(GripperTest, AllocatesNothing) {
  hand_.Put(0.02);
  const test::RealtimeGuard guard;
  for (int k = 0; k < 3000; ++k) {
    if (k == 10) static_cast<void>(gripper_.Start(hand::Homing{}));
    if (k == 200) static_cast<void>(gripper_.Start(hand::Move{0.05, 0.1}));
    if (k == 1000) static_cast<void>(gripper_.Start(hand::Grasp{0.02, 0.1, 20}));
    if (k == 2500) static_cast<void>(gripper_.Start(hand::Stop{}));
    Cycle();
  }
  const test::RealtimeGuard::Counts counts = guard.counts();
  EXPECT_EQ(counts, test::RealtimeGuard::Counts{});
}

}  // namespace
}  // namespace twin::onboard::onboard_gripper_test
