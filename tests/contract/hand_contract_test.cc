// What every hand behind the seam does, whatever advances its time.

#include "twin/backend/hand.h"

#include <functional>
#include <optional>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "contract/backend_harness.h"
#include "support/undisturbed.h"
#include "twin/core/error.h"

namespace twin::test::hand_contract_test {
namespace {

class HandContractTest : public testing::TestWithParam<HarnessCase> {
 protected:
  void MakeHarness() {
    robot::RobotConfig config = HarnessRobot(GetParam().plant_kind);
    config.plant.hand = plant::HandKind::kFrankaHand;
    harness_.reset();
    harness_ = GetParam().make(config);
  }
  /// Runs `attempt` with a new hand, again where the machine did not let it answer.
  void WithHand(const std::function<void()>& attempt) {
    Undisturbed(
        [&] {
          MakeHarness();
          ASSERT_NE(harness_->hand(), nullptr);
          attempt();
        },
        [] { return kGivenUp; }, ByWitness(GetParam().fifo_priority));
  }
  [[nodiscard]] backend::Hand& hand() { return *harness_->hand(); }

  void PassCycles(int cycles) {
    RobotState state;
    for (int k = 0; k < cycles; ++k) {
      ASSERT_TRUE(harness_->AwaitState(state, backend::ReadRule::kNewest));
    }
  }
  /// Lets time pass until the command has ended; nothing when it has not in 10 s.
  std::optional<HandResult> Await(HandTicket ticket) {
    for (int k = 0; k < 1000; ++k) {
      if (const auto result = hand().Outcome(ticket)) return result;
      PassCycles(10);
    }
    return {};
  }

  std::unique_ptr<BackendHarness> harness_;
};

TEST_P(HandContractTest, MovesToAWidthAndTellsWhenItIsThere) {
  WithHand([this] {
    const HandTicket ticket = hand().Start(hand::Move{0.05, 0.1});
    EXPECT_EQ(Await(ticket), HandResult::kSuccess);
    EXPECT_NEAR(hand().ReadState().width, 0.05, 2e-4);
    EXPECT_EQ(hand().Outcome(ticket), HandResult::kSuccess);
  });
}

TEST_P(HandContractTest, KnowsItsLargestOpeningAfterHoming) {
  WithHand([this] {
    PassCycles(2);
    EXPECT_EQ(hand().ReadState().max_width, 0);
    EXPECT_EQ(Await(hand().Start(hand::Homing{})), HandResult::kSuccess);
    EXPECT_NEAR(hand().ReadState().max_width, 0.08, 1e-4);
  });
}

TEST_P(HandContractTest, GraspOfNothingIsUnsuccessful) {
  WithHand([this] {
    const hand::Grasp grasp{.width = 0.04, .speed = 0.1, .force = 20};
    EXPECT_EQ(Await(hand().Start(grasp)), HandResult::kUnsuccessful);
    EXPECT_FALSE(hand().ReadState().is_grasped);
  });
}

// So slow that whatever the machine does, they have not ended.
TEST_P(HandContractTest, StopAndNewCommandsAbortWhatRuns) {
  WithHand([this] {
    const HandTicket first = hand().Start(hand::Move{0.07, 1e-5});
    PassCycles(20);
    EXPECT_FALSE(hand().Outcome(first).has_value());
    const HandTicket second = hand().Start(hand::Move{0.01, 1e-5});
    EXPECT_EQ(hand().Outcome(first), HandResult::kAborted);
    PassCycles(20);
    const HandTicket stop = hand().Start(hand::Stop{});
    EXPECT_EQ(hand().Outcome(second), HandResult::kAborted);
    EXPECT_EQ(hand().Outcome(stop), HandResult::kSuccess);
  });
}

TEST_P(HandContractTest, NamesWhatItRefuses) {
  WithHand([this] {
    const auto refusal = [this](const HandCommand& command) -> std::string {
      try {
        hand().Start(command);
      } catch (const InputError& error) {
        return error.what();
      }
      return "not refused";
    };
    EXPECT_EQ(refusal(hand::Grasp{.width = 0.05, .speed = 0.1, .force = 150}),
              "Grasp rejected: force is 150; it must be above 0 and at most 140 N");
    EXPECT_EQ(refusal(hand::Move{.width = 0.09, .speed = 0.1}),
              "Move rejected: width is 0.09; it must be in [0, the hand's largest opening] m");
  });
}

TEST_P(HandContractTest, CountsItsCycles) {
  WithHand([this] {
    PassCycles(3);
    const std::uint32_t before = hand().ReadState().message_id;
    // A hand at the other end of a wire tells of itself less often than the arm.
    for (int k = 0; k < 1000 && hand().ReadState().message_id < before + 5; ++k) PassCycles(5);
    EXPECT_GE(hand().ReadState().message_id, before + 5);
  });
}

TEST_P(HandContractTest, RobotWithoutAHandHasNone) {
  EXPECT_EQ(GetParam().make(HarnessRobot(GetParam().plant_kind))->hand(), nullptr);
}

INSTANTIATE_TEST_SUITE_P(Hands, HandContractTest, testing::ValuesIn(Harnesses()),
                         [](const auto& harness) { return harness.param.name; });

}  // namespace
}  // namespace twin::test::hand_contract_test
