#include "twin/onboard/command_inbox.h"

#include <chrono>

#include <gtest/gtest.h>

namespace twin::onboard::onboard_command_inbox_test {
namespace {

using std::chrono::microseconds;

Time At(int us) {
  return Time(microseconds(us));
}

RobotCommand Answering(std::uint64_t id, double mark = 0) {
  RobotCommand command;
  command.message_id = id;
  command.q_c[0] = mark;
  return command;
}

TEST(CommandInboxTest, TakesTheAnswerThatArrivedByTheDeadline) {
  CommandInbox inbox;
  inbox.Push(Answering(5), At(900));
  const RobotCommand* command = inbox.Select(5, At(900));
  ASSERT_NE(command, nullptr);
  EXPECT_EQ(command->message_id, 5u);
  EXPECT_EQ(inbox.dropped(), 0u);
  EXPECT_EQ(inbox.Select(5, At(1900)), nullptr) << "a command counts once";
}

TEST(CommandInboxTest, DropsAnAnswerThatMissedItsDeadlineInTheNextCycle) {
  CommandInbox inbox;
  inbox.Push(Answering(5), At(901));
  EXPECT_EQ(inbox.Select(5, At(900)), nullptr);
  EXPECT_EQ(inbox.dropped(), 0u) << "it is still waiting";
  EXPECT_EQ(inbox.Select(6, At(1900)), nullptr);
  EXPECT_EQ(inbox.dropped(), 1u);
}

TEST(CommandInboxTest, DropsOldAndFutureIds) {
  CommandInbox inbox;
  inbox.Push(Answering(4), At(100));
  inbox.Push(Answering(6), At(101));
  EXPECT_EQ(inbox.Select(5, At(900)), nullptr);
  EXPECT_EQ(inbox.dropped(), 2u);
}

TEST(CommandInboxTest, PrefersTheNewestOfSeveralAnswers) {
  CommandInbox inbox;
  inbox.Push(Answering(5, 1), At(100));
  inbox.Push(Answering(5, 2), At(200));
  const RobotCommand* command = inbox.Select(5, At(900));
  ASSERT_NE(command, nullptr);
  EXPECT_EQ(command->q_c[0], 2);
  EXPECT_EQ(inbox.dropped(), 1u);
}

TEST(CommandInboxTest, AFloodPushesOutTheOldest) {
  CommandInbox inbox;
  for (std::size_t i = 0; i < CommandInbox::kCapacity + 8; ++i) {
    inbox.Push(Answering(5, static_cast<double>(i)), At(100));
  }
  const RobotCommand* command = inbox.Select(5, At(900));
  ASSERT_NE(command, nullptr);
  EXPECT_EQ(command->q_c[0], static_cast<double>(CommandInbox::kCapacity + 7));
  EXPECT_EQ(inbox.dropped(), CommandInbox::kCapacity + 7);
}

}  // namespace
}  // namespace twin::onboard::onboard_command_inbox_test
