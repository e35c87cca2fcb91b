#include "run/scripts.h"

#include <chrono>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "twin/core/error.h"

namespace twin::run::run_hand_script_test {
namespace {

using namespace std::chrono_literals;  // NOLINT(google-build-using-namespace): 10ms
using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// A hand whose commands end when the test says so.
class FakeHand final : public backend::Hand {
 public:
  HandTicket Start(const HandCommand& command) override {
    if (silent) throw RobotFault("the hand does not answer");
    if (const auto bad = FindBadValue(command, kHandStroke)) throw InputError(Describe(*bad));
    if (!results.empty() && !results.back()) results.back() = HandResult::kAborted;
    started.emplace_back(twin::Name(command));
    results.emplace_back();
    if (std::holds_alternative<hand::Stop>(command)) results.back() = HandResult::kSuccess;
    return static_cast<HandTicket>(results.size());
  }
  std::optional<HandResult> Outcome(HandTicket ticket) const override {
    if (silent) throw RobotFault("the hand does not answer");
    return results.at(ticket - 1);
  }
  HandState ReadState() const override { return state; }

  bool silent = false;
  HandState state;
  std::vector<std::string> started;
  std::vector<std::optional<HandResult>> results;
};

class HandScriptTest : public ::testing::Test {
 protected:
  HandScript Script() {
    return HandScript(events_, hand_,
                      [this](Time, std::string_view text) { told_.emplace_back(text); });
  }

  FakeHand hand_;
  std::vector<scenario::HandEvent> events_;
  std::vector<std::string> told_;
};

constexpr hand::Move kMove{.width = 0.05, .speed = 0.1};
constexpr hand::Grasp kGrasp{.width = 0.05, .speed = 0.1, .force = 20};

Time At(Duration t) {
  return Time(t);
}

TEST_F(HandScriptTest, GivesEachCommandAtItsTimeAndNotBefore) {
  events_ = {{0s, hand::Homing{}}, {1s, kMove}};
  HandScript script = Script();
  EXPECT_EQ(script.Attend(At(0s)), At(10ms));
  hand_.results[0] = HandResult::kSuccess;
  EXPECT_EQ(script.Attend(At(10ms)), At(1s)) << "nothing runs until then";
  EXPECT_EQ(script.Attend(At(1s - 1ns)), At(1s));
  EXPECT_THAT(hand_.started, ElementsAre("Homing"));
  EXPECT_EQ(script.Attend(At(1s)), At(1010ms));
  EXPECT_THAT(hand_.started, ElementsAre("Homing", "Move"));
}

TEST_F(HandScriptTest, TellsHowACommandEndedAndWhatIsHeld) {
  events_ = {{0s, kGrasp}};
  HandScript script = Script();
  static_cast<void>(script.Attend(At(0s)));
  EXPECT_FALSE(script.Report().commands[0].ended);
  hand_.results[0] = HandResult::kSuccess;
  hand_.state = {.width = 0.0501, .is_grasped = true};
  EXPECT_EQ(script.Attend(At(300ms)), Time::max()) << "that was all";
  const HandReport report = script.Report();
  EXPECT_EQ(report.state, hand_.state);
  const HandOutcome& grasp = report.commands[0];
  EXPECT_EQ(grasp.begun, At(0s));
  EXPECT_EQ(grasp.ended, At(300ms));
  EXPECT_EQ(grasp.result, HandResult::kSuccess);
  EXPECT_EQ(grasp.width, 0.0501);
  EXPECT_TRUE(grasp.is_grasped);
  EXPECT_THAT(told_,
              ElementsAre("Grasp started", "Grasp: success; 50.1 mm open, something is grasped"));
}

TEST_F(HandScriptTest, ACommandAbortsTheOneThatRuns) {
  events_ = {{0s, kMove}, {10ms, hand::Stop{}}};
  HandScript script = Script();
  static_cast<void>(script.Attend(At(0s)));
  EXPECT_EQ(script.Attend(At(10ms)), Time::max()) << "a stop has ended at once";
  const HandReport report = script.Report();
  EXPECT_EQ(report.commands[0].result, HandResult::kAborted);
  EXPECT_EQ(report.commands[0].ended, At(10ms));
  EXPECT_EQ(report.commands[1].result, HandResult::kSuccess);
}

TEST_F(HandScriptTest, AllThatIsOverdueIsGivenInItsOrder) {
  events_ = {{0s, hand::Homing{}}, {1ms, kMove}, {1ms, kGrasp}, {1s, hand::Stop{}}};
  HandScript script = Script();
  EXPECT_EQ(script.Attend(At(5ms)), At(15ms));
  EXPECT_THAT(hand_.started, ElementsAre("Homing", "Move", "Grasp"));
  const HandReport report = script.Report();
  EXPECT_EQ(report.commands[1].result, HandResult::kAborted);
  EXPECT_FALSE(report.commands[2].result);
  EXPECT_FALSE(report.commands[3].begun);
}

TEST_F(HandScriptTest, WhatTheHandRefusesHasFailedAndAbortsNothing) {
  events_ = {{0s, kMove}, {10ms, hand::Move{.width = 0.2, .speed = 0.1}}};
  HandScript script = Script();
  static_cast<void>(script.Attend(At(0s)));
  EXPECT_EQ(script.Attend(At(10ms)), At(20ms)) << "the first still runs";
  const HandReport report = script.Report();
  EXPECT_FALSE(report.commands[0].ended);
  EXPECT_EQ(report.commands[1].result, HandResult::kFail);
  EXPECT_THAT(report.commands[1].failure, HasSubstr("width is 0.2"));
  EXPECT_EQ(told_.back(), report.commands[1].failure);
}

TEST_F(HandScriptTest, AHandThatDoesNotAnswerHasFailedAndTheRunGoesOn) {
  events_ = {{0s, kMove}, {1s, kMove}};
  HandScript script = Script();
  static_cast<void>(script.Attend(At(0s)));
  hand_.silent = true;
  EXPECT_EQ(script.Attend(At(10ms)), At(1s));
  EXPECT_EQ(script.Attend(At(1s)), Time::max());
  for (const HandOutcome& outcome : script.Report().commands) {
    EXPECT_EQ(outcome.result, HandResult::kFail);
    EXPECT_EQ(outcome.failure, "the hand does not answer");
  }
}

}  // namespace
}  // namespace twin::run::run_hand_script_test
