#include "twin/robot/link.h"

#include <chrono>
#include <vector>

#include <gtest/gtest.h>

namespace twin::robot {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;

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

TEST(StateLinkTest, DeliversAfterTheDelay) {
  rt::EventQueue events;
  Listener listener;
  LinkConfig config;
  config.state_delay = rt::DelayModel(rt::ConstantDelay{microseconds(250)});
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
  config.state_delay = rt::DelayModel(rt::LogNormalDelay{milliseconds(2), 1.5, {}});
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
    config.state_loss = 0.1;
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
  config.state_delay = rt::DelayModel(rt::ConstantDelay{std::chrono::seconds(1)});
  StateLink link(config, 1, events, listener);
  link.Send(State(1));
  EXPECT_FALSE(events.RunNext());
}

TEST(CommandLinkTest, PutsCommandsIntoTheInboxWithTheirArrival) {
  rt::EventQueue events;
  onboard::CommandInbox inbox;
  LinkConfig config;
  config.command_delay = rt::DelayModel(rt::ConstantDelay{microseconds(300)});
  CommandLink link(config, 1, events, inbox);
  RobotCommand command;
  command.message_id = 9;
  link.Send(command);
  ASSERT_TRUE(events.RunNext());
  EXPECT_EQ(inbox.Select(9, Time(microseconds(299))), nullptr);
  EXPECT_NE(inbox.Select(9, Time(microseconds(300))), nullptr);
}

}  // namespace
}  // namespace twin::robot
