#include "twin/robot/link.h"

#include <algorithm>
#include <chrono>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/realtime_guard.h"
#include "twin/core/error.h"

namespace twin::robot::robot_link_test {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// Notes the ids it is told, and when.
class Listener final : public rt::EventHandler {
 public:
  void OnEvent(Time now, std::uint64_t id) noexcept override {
    ids.push_back(id);
    times.push_back(now);
  }
  std::vector<std::uint64_t> ids;
  std::vector<Time> times;
};

RobotState State(std::uint64_t id) {
  RobotState state;
  state.message_id = id;
  return state;
}

RobotCommand Command(std::uint64_t answered, double mark = 0) {
  RobotCommand command;
  command.message_id = answered;
  command.q_c[0] = mark;
  return command;
}

/// Runs what is due before `until`.
void RunUntil(rt::EventQueue& events, Time until) {
  while (events.NextTime().value_or(until) < until) static_cast<void>(events.RunNext());
  events.AdvanceTo(until);
}

TEST(StateLinkTest, DeliversAfterTheDelay) {
  rt::EventQueue events;
  Listener listener;
  LinkConfig config;
  config.state.delay = faults::DelayModel(faults::ConstantDelay{microseconds(250)});
  StateLink link(config, 1, events, listener);
  link.Send(State(1));
  EXPECT_FALSE(link.has_new());
  ASSERT_TRUE(events.RunNext());
  EXPECT_EQ(listener.times, std::vector<Time>{Time(microseconds(250))});
  ASSERT_TRUE(link.has_new());
  EXPECT_EQ(link.Take().message_id, 1u);
  EXPECT_FALSE(link.has_new());
}

TEST(StateLinkTest, ANewerStateWinsOverOneThatItOvertook) {
  rt::EventQueue events;
  Listener listener;
  LinkConfig config;
  config.state.delay = faults::DelayModel(faults::LogNormalDelay{milliseconds(2), 1.5, {}});
  StateLink link(config, 3, events, listener);
  for (std::uint64_t id = 1; id <= 200; ++id) link.Send(State(id));
  while (events.RunNext()) {
  }
  ASSERT_GT(listener.ids.size(), 1u);
  EXPECT_LT(listener.ids.size(), 200u) << "the delays never reordered: the test shows nothing";
  for (std::size_t i = 1; i < listener.ids.size(); ++i) {
    EXPECT_GT(listener.ids[i], listener.ids[i - 1]);
  }
  EXPECT_EQ(link.Take().message_id, 200u);
}

TEST(StateLinkTest, LosesTheConfiguredShareAndTheSameMessagesForTheSameSeed) {
  const auto delivered = [](std::uint64_t seed) {
    rt::EventQueue events;
    Listener listener;
    LinkConfig config;
    config.state.loss = faults::LossModel(faults::IndependentLoss{0.1});
    StateLink link(config, seed, events, listener);
    for (std::uint64_t id = 1; id <= 10000; ++id) {
      link.Send(State(id));
      while (events.RunNext()) {
      }
    }
    return listener.ids;
  };
  const auto first = delivered(5);
  EXPECT_NEAR(static_cast<double>(first.size()), 9000, 150);  // 5 standard deviations
  EXPECT_EQ(first, delivered(5));
  EXPECT_NE(first, delivered(6));
}

TEST(StateLinkTest, AStateThatWouldTakeLongerThanAnyUseOfItIsLost) {
  rt::EventQueue events;
  Listener listener;
  LinkConfig config;
  config.state.delay = faults::DelayModel(faults::ConstantDelay{std::chrono::seconds(1)});
  StateLink link(config, 1, events, listener);
  link.Send(State(1));
  EXPECT_FALSE(events.RunNext());
}

TEST(CommandLinkTest, PutsCommandsIntoTheInboxWithTheirArrival) {
  rt::EventQueue events;
  onboard::CommandInbox inbox;
  LinkConfig config;
  config.command.delay = faults::DelayModel(faults::ConstantDelay{microseconds(300)});
  CommandLink link(config, 1, events, inbox);
  RobotCommand command;
  command.message_id = 9;
  link.Send(command);
  ASSERT_TRUE(events.RunNext());
  EXPECT_EQ(inbox.Select(9, Time(microseconds(299))), nullptr);
  EXPECT_NE(inbox.Select(9, Time(microseconds(300))), nullptr);
}

TEST(StateLinkTest, DelayAndIndependentLossAreTheDrawsForItsId) {
  rt::EventQueue events;
  Listener listener;
  LinkConfig config;
  config.state.delay =
      faults::DelayModel(faults::LogNormalDelay{microseconds(50), 0.5, microseconds(30)});
  config.state.loss = faults::LossModel(faults::IndependentLoss{0.2});
  StateLink link(config, 17, events, listener);
  std::vector<std::uint64_t> ids;
  std::vector<Time> times;
  const Random loss(17, RandomStream::kStateLoss);
  const Random delay(17, RandomStream::kStateDelay);
  for (std::uint64_t id = 1; id <= 500; ++id) {
    const Time sent(id * kCycle);
    RunUntil(events, sent);
    link.Send(State(id));
    if (loss.Uniform(id) < 0.2) continue;
    ids.push_back(id);
    times.push_back(sent + config.state.delay.Draw(delay, id));
  }
  RunUntil(events, Time(std::chrono::seconds(1)));
  EXPECT_EQ(listener.ids, ids);
  EXPECT_EQ(listener.times, times);
}

TEST(StateLinkTest, TellsOfADuplicatedStateOnce) {
  rt::EventQueue events;
  Listener listener;
  LinkConfig config;
  config.state.duplication = 1;
  config.state.duplicate_delay = faults::DelayModel(faults::ConstantDelay{microseconds(200)});
  StateLink link(config, 1, events, listener);
  link.Send(State(1));
  EXPECT_EQ(events.pending(), 2u);
  ASSERT_TRUE(events.RunNext());
  EXPECT_EQ(link.Take().message_id, 1u);
  ASSERT_TRUE(events.RunNext());
  EXPECT_FALSE(link.has_new());
  EXPECT_THAT(listener.ids, ElementsAre(1));
}

TEST(StateLinkTest, AStateHeldBackBehindItsSuccessorIsDropped) {
  rt::EventQueue events;
  Listener listener;
  LinkConfig config;
  config.state.reordering = 0.1;
  config.state.reorder_by = microseconds(1500);
  StateLink link(config, 4, events, listener);
  constexpr std::uint64_t kStates = 2000;
  for (std::uint64_t id = 1; id <= kStates; ++id) {
    RunUntil(events, Time(id * kCycle));
    link.Send(State(id));
  }
  RunUntil(events, Time((kStates + 10) * kCycle));
  // One that is held back arrives only if its successor is held back too.
  const Random held(4, RandomStream::kStateReorder);
  std::vector<std::uint64_t> expected;
  for (std::uint64_t id = 1; id <= kStates; ++id) {
    const bool overtaken = id < kStates && held.Uniform(id + 1) >= 0.1;
    if (held.Uniform(id) >= 0.1 || !overtaken) expected.push_back(id);
  }
  EXPECT_LT(expected.size(), kStates - 100) << "nothing was held back: the test shows nothing";
  EXPECT_EQ(listener.ids, expected);
}

TEST(StateLinkTest, LosesTheStatesOfAScript) {
  rt::EventQueue events;
  Listener listener;
  LinkConfig config;
  config.state.loss = faults::LossModel(faults::ScriptedLoss{{{2, 1}, {4, 2}}});
  StateLink link(config, 1, events, listener);
  for (std::uint64_t id = 1; id <= 7; ++id) link.Send(State(id));
  while (events.RunNext()) {
  }
  EXPECT_THAT(listener.ids, ElementsAre(1, 3, 6, 7));
}

/// The commands in an inbox that answer `id` and have arrived by `at`.
struct Found {
  std::optional<double> chosen;  ///< mark of the one that counts
  std::uint32_t dropped = 0;     ///< others
};
Found Look(onboard::CommandInbox& inbox, std::uint64_t id, Time at) {
  const RobotCommand* command = inbox.Select(id, at);
  Found found;
  if (command != nullptr) found.chosen = command->q_c[0];
  found.dropped = inbox.dropped();
  return found;
}

TEST(CommandLinkTest, PutsBothCopiesOfADuplicatedCommandIntoTheInbox) {
  rt::EventQueue events;
  onboard::CommandInbox inbox;
  LinkConfig config;
  config.command.duplication = 1;
  config.command.duplicate_delay = faults::DelayModel(faults::ConstantDelay{microseconds(200)});
  CommandLink link(config, 1, events, inbox);
  link.Send(Command(9, 0.5));
  while (events.RunNext()) {
  }
  EXPECT_EQ(events.Now(), Time(microseconds(200)));
  const Found found = Look(inbox, 9, events.Now());
  EXPECT_EQ(found.chosen, 0.5);
  EXPECT_EQ(found.dropped, 1u);
}

TEST(CommandLinkTest, ACopyThatWouldTakeTooLongDoesNotTakeTheFirstWithIt) {
  rt::EventQueue events;
  onboard::CommandInbox inbox;
  LinkConfig config;
  config.command.duplication = 1;
  config.command.duplicate_delay =
      faults::DelayModel(faults::ConstantDelay{std::chrono::seconds(1)});
  CommandLink link(config, 1, events, inbox);
  link.Send(Command(9));
  EXPECT_EQ(events.pending(), 1u);
}

TEST(CommandLinkTest, ACommandHeldBackArrivesAfterItsSuccessor) {
  rt::EventQueue events;
  onboard::CommandInbox inbox;
  LinkConfig config;
  config.command.reordering = 0.3;
  config.command.reorder_by = microseconds(1500);
  CommandLink link(config, 4, events, inbox);
  const Random held(4, RandomStream::kCommandReorder);
  int held_back = 0;
  for (std::uint64_t id = 1; id <= 200; ++id) {
    const Time sent(id * kCycle);
    RunUntil(events, sent);
    link.Send(Command(id));
    RunUntil(events, sent + microseconds(900));
    const bool in_time = Look(inbox, id, events.Now()).chosen.has_value();
    ASSERT_EQ(in_time, held.Uniform(id) >= 0.3) << id;
    held_back += in_time ? 0 : 1;
  }
  EXPECT_GT(held_back, 20);
}

TEST(CommandLinkTest, ASecondAnswerToAStateIsLostOrNotOnItsOwn) {
  LinkConfig config;
  config.command.loss = faults::LossModel(faults::IndependentLoss{0.5});
  config.command.delay = faults::DelayModel(faults::LogNormalDelay{microseconds(50), 1, {}});
  const auto arrivals = [&] {
    rt::EventQueue events;
    onboard::CommandInbox inbox;
    CommandLink link(config, 2, events, inbox);
    std::vector<std::pair<std::optional<double>, std::uint32_t>> found;
    for (std::uint64_t id = 1; id <= 1000; ++id) {
      link.Send(Command(id, 1));
      link.Send(Command(id, 2));
      while (events.RunNext()) {
      }
      const Found each = Look(inbox, id, events.Now());
      found.emplace_back(each.chosen, each.dropped);
    }
    return found;
  };
  const auto found = arrivals();
  const auto count = [&](std::optional<double> chosen, std::uint32_t dropped) {
    return std::count(found.begin(), found.end(), std::pair(chosen, dropped));
  };
  // Each of the four cases has a share of 1/4; 5 standard deviations. When both arrive the second
  // is the newer: they take the same time.
  EXPECT_NEAR(count(std::nullopt, 0), 250, 70);
  EXPECT_NEAR(count(1, 0), 250, 70);
  EXPECT_NEAR(count(2, 0), 250, 70);
  EXPECT_NEAR(count(2, 1), 250, 70);
  EXPECT_EQ(found, arrivals());
}

TEST(CommandLinkTest, WhatHappensToACommandDoesNotDependOnThoseBefore) {
  LinkConfig config;
  config.command.loss = faults::LossModel(faults::GilbertElliottLoss{0.05, 0.3, 0.01, 0.9});
  const auto lost = [&](std::uint64_t step) {
    rt::EventQueue events;
    onboard::CommandInbox inbox;
    CommandLink link(config, 2, events, inbox);
    std::vector<std::uint64_t> ids;
    for (std::uint64_t id = step; id <= 6000; id += step) {
      link.Send(Command(id));
      if (!events.RunNext() && id % 6 == 0) ids.push_back(id);
    }
    return ids;
  };
  ASSERT_GT(lost(1).size(), 50u);
  EXPECT_EQ(lost(1), lost(2));
  EXPECT_EQ(lost(1), lost(6));
}

TEST(CommandLinkTest, LosesWhatExceedsItsRoomAndTakesMoreOnceSomeHasArrived) {
  constexpr std::size_t kCapacity = Channel<RobotCommand>::kCapacity;
  rt::EventQueue events;
  onboard::CommandInbox inbox;
  LinkConfig config;
  config.command.delay = faults::DelayModel(faults::ConstantDelay{milliseconds(200)});
  CommandLink link(config, 1, events, inbox);
  for (std::size_t i = 0; i < kCapacity + 10; ++i) link.Send(Command(i));
  EXPECT_EQ(events.pending(), kCapacity);
  ASSERT_TRUE(events.RunNext());
  link.Send(Command(1));
  link.Send(Command(2));
  EXPECT_EQ(events.pending(), kCapacity);
}

TEST(LinkTest, SendsAndDeliversWithoutAllocation) {
  rt::EventQueue events;
  onboard::CommandInbox inbox;
  class Nobody final : public rt::EventHandler {
    void OnEvent(Time, std::uint64_t) noexcept override {}
  } nobody;
  LinkConfig config;
  for (faults::DirectionConfig* direction : {&config.state, &config.command}) {
    direction->delay = faults::DelayModel(faults::GammaDelay{2, milliseconds(1), microseconds(50)});
    direction->loss = faults::LossModel(faults::GilbertElliottLoss{0.02, 0.2, 0.01, 0.9});
    direction->duplication = 0.3;
    direction->duplicate_delay = faults::DelayModel(faults::ConstantDelay{milliseconds(2)});
    direction->reordering = 0.2;
    direction->reorder_by = milliseconds(3);
  }
  StateLink states(config, 1, events, nobody);
  CommandLink commands(config, 1, events, inbox);
  RobotState state;
  RobotCommand command;
  const test::RealtimeGuard guard;
  for (std::uint64_t id = 1; id <= 2000; ++id) {
    state.message_id = id;
    command.message_id = id;
    RunUntil(events, Time(id * kCycle));
    states.Send(state);
    commands.Send(command);
  }
  const auto counts = guard.counts();
  EXPECT_EQ(counts, test::RealtimeGuard::Counts{});
  EXPECT_GT(states.Take().message_id, 1900u);
}

/// The text a link is refused with; empty when it is accepted.
std::string RefusalOf(const LinkConfig& config) {
  try {
    config.Validate();
  } catch (const InputError& error) {
    return error.what();
  }
  return {};
}

TEST(LinkConfigTest, NamesTheFieldThatIsOutOfRange) {
  EXPECT_EQ(RefusalOf(LinkConfig()), "");
  LinkConfig config;
  config.state.duplication = -0.5;
  EXPECT_THAT(RefusalOf(config), HasSubstr("link.state.duplication is -0.5"));
  config = LinkConfig();
  config.command.reordering = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(RefusalOf(config), HasSubstr("link.command.reordering is nan"));
  config = LinkConfig();
  config.command.reordering = 0.1;
  EXPECT_THAT(RefusalOf(config), HasSubstr("link.command.reorder_by is 0 ns"));
  config.command.reorder_by = kLongestOnTheWay;
  EXPECT_EQ(RefusalOf(config), "");
  config.command.reorder_by += Duration(1);
  EXPECT_THAT(RefusalOf(config), HasSubstr("link.command.reorder_by"));
  for (const Duration bad : {Duration(-1), kCycle}) {
    config = LinkConfig();
    config.d_INT = bad;
    EXPECT_THAT(RefusalOf(config), HasSubstr("link.d_INT"));
  }
}

}  // namespace
}  // namespace twin::robot::robot_link_test
