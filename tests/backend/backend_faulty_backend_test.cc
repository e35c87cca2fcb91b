#include "twin/backend/faulty_backend.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <iterator>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/realtime_guard.h"
#include "twin/core/error.h"

namespace twin::backend::backend_faulty_backend_test {
namespace {

using ::testing::ElementsAre;
using Ids = std::vector<std::uint64_t>;

/// A robot that has one state after the other, and notes what is asked of it.
class ScriptedBackend final : public Backend {
 public:
  ScriptedBackend() { written.reserve(10'000); }

  Description Describe() const override {
    Description description;
    description.name = "scripted";
    description.robot = "a script";
    return description;
  }
  void Configure(const Setting&) override { ++configured; }
  void Start(const MotionModes&) override { ++started; }
  ReadResult Read(ReadRule rule, RobotState& state, Time& arrival) noexcept override {
    last_rule = rule;
    if (result != ReadResult::kState) return result;
    state = next;
    arrival = Time(next.message_id * kCycle);
    ++next.message_id;
    return ReadResult::kState;
  }
  void Write(const RobotCommand& command) noexcept override {
    if (written.size() < written.capacity()) written.push_back(command);
  }
  void Stop() override { ++stopped; }
  void Recover() override { ++recovered; }

  ReadResult result = ReadResult::kState;
  RobotState next;
  ReadRule last_rule = ReadRule::kNewest;
  std::vector<RobotCommand> written;
  int configured = 0;
  int started = 0;
  int stopped = 0;
  int recovered = 0;
};

class FaultyBackendTest : public ::testing::Test {
 protected:
  void Make(FaultPlan plan) {
    auto inner = std::make_unique<ScriptedBackend>();
    inner_ = inner.get();
    inner_->next.message_id = 1;
    faulty_ = std::make_unique<FaultyBackend>(std::move(inner), std::move(plan));
  }

  ReadResult Read() { return faulty_->Read(ReadRule::kNewest, state_, arrival_); }

  /// Reads up to `count` states of the robot. @returns the ids of those that came.
  Ids ReadAll(std::uint64_t count) {
    Ids ids;
    for (std::uint64_t i = 0; i < count; ++i) {
      if (Read() == ReadResult::kState) ids.push_back(state_.message_id);
    }
    return ids;
  }

  /// Writes commands that answer 1 to `count`. @returns the ids of what reached the robot.
  Ids WriteAll(std::uint64_t count) {
    for (std::uint64_t id = 1; id <= count; ++id) faulty_->Write(Command(id));
    return Written();
  }
  Ids Written() const {
    Ids ids;
    for (const RobotCommand& command : inner_->written) ids.push_back(command.message_id);
    return ids;
  }

  static RobotCommand Command(std::uint64_t id) {
    RobotCommand command;
    command.message_id = id;
    command.q_c.fill(static_cast<double>(id));
    return command;
  }

  ScriptedBackend* inner_ = nullptr;
  std::unique_ptr<FaultyBackend> faulty_;
  RobotState state_;
  Time arrival_{};
};

Ids UpTo(std::uint64_t count) {
  Ids ids;
  for (std::uint64_t id = 1; id <= count; ++id) ids.push_back(id);
  return ids;
}

FaultPlan PlanOf(FaultSchedule FaultPlan::*fault, FaultSchedule schedule, std::uint64_t seed = 1) {
  FaultPlan plan;
  plan.seed = seed;
  plan.*fault = std::move(schedule);
  return plan;
}

constexpr FaultSchedule FaultPlan::*kSchedules[] = {
    &FaultPlan::command_duplicated, &FaultPlan::command_swapped, &FaultPlan::command_delayed,
    &FaultPlan::command_garbage};

TEST_F(FaultyBackendTest, WithoutFaultsPassesEverythingOn) {
  Make({});
  EXPECT_EQ(ReadAll(5), UpTo(5));
  EXPECT_EQ(arrival_, Time(5 * kCycle));
  EXPECT_EQ(WriteAll(5), UpTo(5));
  EXPECT_EQ(inner_->written.back().q_c, Command(5).q_c);
  faulty_->Configure(setting::JointImpedance{});
  faulty_->Start({});
  faulty_->Stop();
  faulty_->Recover();
  EXPECT_EQ(inner_->configured + inner_->started + inner_->stopped + inner_->recovered, 4);
  static_cast<void>(faulty_->Read(ReadRule::kFresh, state_, arrival_));
  EXPECT_EQ(inner_->last_rule, ReadRule::kFresh);
  inner_->result = ReadResult::kPending;
  EXPECT_EQ(Read(), ReadResult::kPending);
  inner_->result = ReadResult::kLost;
  EXPECT_EQ(Read(), ReadResult::kLost);
  EXPECT_EQ(faulty_->counts(), FaultCounts());
}

TEST_F(FaultyBackendTest, SaysThatItInjectsFaults) {
  Make({.seed = 42});
  const Description description = faulty_->Describe();
  EXPECT_EQ(description.name, "scripted");
  EXPECT_EQ(description.robot, "a script, with injected faults (seed 42)");
}

TEST_F(FaultyBackendTest, ALostStateIsPendingAndLeavesTheReadersOwn) {
  Make({.state_loss = faults::LossModel(faults::ScriptedLoss{{{3, 2}}})});
  EXPECT_EQ(ReadAll(2), UpTo(2));
  EXPECT_EQ(Read(), ReadResult::kPending);
  EXPECT_EQ(Read(), ReadResult::kPending);
  EXPECT_EQ(state_.message_id, 2u);
  EXPECT_EQ(arrival_, Time(2 * kCycle));
  EXPECT_EQ(Read(), ReadResult::kState);
  EXPECT_EQ(state_.message_id, 5u);
  EXPECT_EQ(faulty_->counts(), FaultCounts{.states_lost = 2});
}

TEST_F(FaultyBackendTest, IdsOfStatesRiseUnderRandomLoss) {
  Make({.state_loss = faults::LossModel(faults::GilbertElliottLoss{0.05, 0.2, 0.01, 0.9})});
  const Ids ids = ReadAll(2000);
  EXPECT_TRUE(std::is_sorted(ids.begin(), ids.end(), std::less_equal<>()));
  EXPECT_EQ(ids.size() + faulty_->counts().states_lost, 2000u);
  EXPECT_GT(faulty_->counts().states_lost, 100u);
}

TEST_F(FaultyBackendTest, LosesTheCommandsOfAScript) {
  Make({.command_loss = faults::LossModel(faults::ScriptedLoss{{{2, 1}, {4, 3}}})});
  EXPECT_THAT(WriteAll(8), ElementsAre(1, 3, 7, 8));
  EXPECT_EQ(faulty_->counts(), FaultCounts{.commands_lost = 4});
}

TEST_F(FaultyBackendTest, WritesADuplicatedCommandTwice) {
  Make(PlanOf(&FaultPlan::command_duplicated, {.messages = {2, 4}}));
  EXPECT_THAT(WriteAll(5), ElementsAre(1, 2, 2, 3, 4, 4, 5));
  EXPECT_EQ(faulty_->counts(), FaultCounts{.commands_duplicated = 2});
}

TEST_F(FaultyBackendTest, WritesASwappedCommandAfterTheNext) {
  Make(PlanOf(&FaultPlan::command_swapped, {.messages = {2, 5}}));
  EXPECT_THAT(WriteAll(7), ElementsAre(1, 3, 2, 4, 6, 5, 7));
  EXPECT_EQ(faulty_->counts(), FaultCounts{.commands_swapped = 2});
}

TEST_F(FaultyBackendTest, HoldsADelayedCommandUntilTheNextWrite) {
  Make(PlanOf(&FaultPlan::command_delayed, {.messages = {2}}));
  EXPECT_THAT(WriteAll(2), ElementsAre(1));
  faulty_->Write(Command(3));
  EXPECT_THAT(Written(), ElementsAre(1, 2, 3));
  EXPECT_EQ(faulty_->counts(), FaultCounts{.commands_delayed = 1});
}

TEST_F(FaultyBackendTest, DelayedCommandsInARowStayInOrder) {
  Make(PlanOf(&FaultPlan::command_delayed, {.messages = {2, 3, 4}}));
  EXPECT_THAT(WriteAll(4), ElementsAre(1, 2, 3));
  faulty_->Write(Command(5));
  EXPECT_THAT(Written(), ElementsAre(1, 2, 3, 4, 5));
}

TEST_F(FaultyBackendTest, SwapsPairsWhenEveryCommandWouldBeSwapped) {
  Make(PlanOf(&FaultPlan::command_swapped, {.probability = 1}));
  EXPECT_THAT(WriteAll(6), ElementsAre(2, 1, 4, 3, 6, 5));
}

TEST_F(FaultyBackendTest, ASwappedCommandArrivesEvenWhenTheNextIsLost) {
  FaultPlan plan = PlanOf(&FaultPlan::command_swapped, {.messages = {2}});
  plan.command_loss = faults::LossModel(faults::ScriptedLoss{{{3, 1}}});
  Make(plan);
  EXPECT_THAT(WriteAll(4), ElementsAre(1, 2, 4));
}

TEST_F(FaultyBackendTest, BothCopiesOfADuplicatedCommandAreHeld) {
  FaultPlan plan = PlanOf(&FaultPlan::command_duplicated, {.messages = {2}});
  plan.command_swapped = {.messages = {2}};
  Make(plan);
  EXPECT_THAT(WriteAll(4), ElementsAre(1, 3, 2, 2, 4));
}

struct ActiveField {
  MotionGeneratorMode generator;
  ControllerMode controller;
  std::string names;  ///< of the fields that must be NaN
};
void PrintTo(const ActiveField& active, std::ostream* out) {
  *out << active.names;
}

/// The names of the fields that are NaN throughout; "mixed" when one is so in part.
std::string SpoiltFields(const RobotCommand& command) {
  std::string names;
  const auto look = [&](const char* name, const auto& field) {
    const auto nans =
        std::count_if(field.begin(), field.end(), [](double x) { return std::isnan(x); });
    if (nans == 0) return;
    names += nans == static_cast<std::ptrdiff_t>(field.size()) ? name : "mixed";
    names += ' ';
  };
  look("q_c", command.q_c);
  look("dq_c", command.dq_c);
  look("O_T_EE_c", command.O_T_EE_c);
  look("O_dP_EE_c", command.O_dP_EE_c);
  look("elbow_c", command.elbow_c);
  look("tau_J_d", command.tau_J_d);
  return names;
}

class GarbageTest : public FaultyBackendTest, public testing::WithParamInterface<ActiveField> {};

TEST_P(GarbageTest, SpoilsTheFieldsThatTheMotionUses) {
  Make(PlanOf(&FaultPlan::command_garbage, {.messages = {2}}));
  inner_->next.motion_generator_mode = GetParam().generator;
  inner_->next.controller_mode = GetParam().controller;
  ASSERT_EQ(Read(), ReadResult::kState);
  for (const std::uint64_t id : {1, 2, 3}) {
    RobotCommand command = Command(id);
    command.valid_elbow = true;
    faulty_->Write(command);
  }
  ASSERT_EQ(inner_->written.size(), 3u);
  EXPECT_EQ(SpoiltFields(inner_->written[0]), "");
  EXPECT_EQ(SpoiltFields(inner_->written[1]), GetParam().names);
  EXPECT_EQ(SpoiltFields(inner_->written[2]), "");
  EXPECT_EQ(faulty_->counts(), FaultCounts{.commands_garbage = GetParam().names.empty() ? 0u : 1u});
}

INSTANTIATE_TEST_SUITE_P(
    Modes, GarbageTest,
    testing::Values(
        ActiveField{MotionGeneratorMode::kIdle, ControllerMode::kOther, ""},
        ActiveField{MotionGeneratorMode::kJointPosition, ControllerMode::kJointImpedance, "q_c "},
        ActiveField{MotionGeneratorMode::kJointVelocity, ControllerMode::kJointImpedance, "dq_c "},
        ActiveField{MotionGeneratorMode::kCartesianPosition, ControllerMode::kCartesianImpedance,
                    "O_T_EE_c elbow_c "},
        ActiveField{MotionGeneratorMode::kCartesianVelocity, ControllerMode::kJointImpedance,
                    "O_dP_EE_c elbow_c "},
        ActiveField{MotionGeneratorMode::kIdle, ControllerMode::kExternalController, "tau_J_d "},
        ActiveField{MotionGeneratorMode::kJointPosition, ControllerMode::kExternalController,
                    "q_c tau_J_d "}));

TEST_F(FaultyBackendTest, OnceGoneTheConnectionStaysGone) {
  Make({.gone_from = 4});
  EXPECT_EQ(ReadAll(3), UpTo(3));
  faulty_->Write(Command(3));
  for (int i = 0; i < 3; ++i) EXPECT_EQ(Read(), ReadResult::kLost);
  EXPECT_EQ(state_.message_id, 3u);
  faulty_->Write(Command(4));
  faulty_->Stop();
  EXPECT_THAT(Written(), ElementsAre(3));
  EXPECT_EQ(inner_->stopped, 0);
  EXPECT_THROW(faulty_->Configure(setting::JointImpedance{}), RobotFault);
  EXPECT_THROW(faulty_->Start({}), RobotFault);
  EXPECT_THROW(faulty_->Recover(), RobotFault);
  EXPECT_EQ(inner_->configured + inner_->started + inner_->recovered, 0);
  inner_->result = ReadResult::kPending;
  EXPECT_EQ(Read(), ReadResult::kLost);
}

TEST_F(FaultyBackendTest, TheConnectionIsGoneAlsoWhenItsStateWasSkipped) {
  Make({.gone_from = 4});
  inner_->next.message_id = 9;
  EXPECT_EQ(Read(), ReadResult::kLost);
}

TEST_F(FaultyBackendTest, AFaultStrikesWithItsProbability) {
  constexpr std::uint64_t kCommands = 4000;
  constexpr double kP = 0.1;
  const double tolerance = 5 * std::sqrt(kP * (1 - kP) * kCommands);
  const auto counts = [&](FaultSchedule FaultPlan::*fault) {
    Make(PlanOf(fault, {.probability = kP}));
    inner_->next.motion_generator_mode = MotionGeneratorMode::kJointPosition;
    EXPECT_EQ(Read(), ReadResult::kState);
    WriteAll(kCommands);
    return faulty_->counts();
  };
  EXPECT_NEAR(counts(&FaultPlan::command_duplicated).commands_duplicated, kP * kCommands,
              tolerance);
  EXPECT_NEAR(counts(&FaultPlan::command_delayed).commands_delayed, kP * kCommands, tolerance);
  EXPECT_NEAR(counts(&FaultPlan::command_garbage).commands_garbage, kP * kCommands, tolerance);
  // The partner of a swap is not swapped itself: p / (1 + p) of the commands are.
  EXPECT_NEAR(counts(&FaultPlan::command_swapped).commands_swapped, kP / (1 + kP) * kCommands,
              tolerance);
}

TEST_F(FaultyBackendTest, EveryFaultRepeatsWithTheSeedAndChangesWithIt) {
  for (const auto fault :
       {&FaultPlan::command_duplicated, &FaultPlan::command_swapped, &FaultPlan::command_delayed}) {
    const auto written = [&](std::uint64_t seed) {
      Make(PlanOf(fault, {.probability = 0.2}, seed));
      Ids ids;
      for (std::uint64_t id = 1; id <= 200; ++id) {
        faulty_->Write(Command(id));
        ids.push_back(inner_->written.size());  // tells a delayed command from one in time
      }
      const Ids order = Written();
      ids.insert(ids.end(), order.begin(), order.end());
      return ids;
    };
    EXPECT_EQ(written(1), written(1));
    EXPECT_NE(written(1), written(2));
  }
}

TEST_F(FaultyBackendTest, DrawsApartFromTheLinkWithTheSameSeed) {
  constexpr std::uint64_t kSeed = 5;
  const faults::LossModel half(faults::IndependentLoss{0.5});
  faults::LossProcess link(half, kSeed, RandomStream::kCommandLoss, RandomStream::kCommandBurst);
  Make({.seed = kSeed, .command_loss = half});
  const Ids written = WriteAll(1000);
  int same = 0;
  for (std::uint64_t id = 1; id <= 1000; ++id) {
    const bool arrived = std::binary_search(written.begin(), written.end(), id);
    same += arrived != link.Loses(id) ? 1 : 0;
  }
  EXPECT_NEAR(same, 500, 80);  // 5 standard deviations
}

TEST_F(FaultyBackendTest, StatesAndCommandsAreLostIndependently) {
  const faults::LossModel half(faults::IndependentLoss{0.5});
  Make({.seed = 5, .state_loss = half, .command_loss = half});
  const Ids read = ReadAll(1000);
  const Ids written = WriteAll(1000);
  Ids both;
  std::set_intersection(read.begin(), read.end(), written.begin(), written.end(),
                        std::back_inserter(both));
  EXPECT_NEAR(static_cast<double>(both.size()), 250, 69);  // 5 standard deviations
}

TEST_F(FaultyBackendTest, ReadsAndWritesWithoutAllocation) {
  FaultPlan plan;
  plan.state_loss = faults::LossModel(faults::GilbertElliottLoss{0.05, 0.2, 0.01, 0.9});
  plan.command_loss = faults::LossModel(faults::ScriptedLoss{{{3, 2}, {500, 10}}});
  for (const auto fault : kSchedules) plan.*fault = {.probability = 0.1, .messages = {7, 70}};
  plan.command_delayed.messages = {20};
  plan.command_swapped.messages = {10};
  plan.gone_from = 1500;
  Make(plan);
  faulty_->Start({});
  inner_->next.motion_generator_mode = MotionGeneratorMode::kJointPosition;
  RobotCommand command;
  int lost = 0;
  const test::RealtimeGuard guard;
  for (int i = 0; i < 1600; ++i) {
    const ReadResult result = faulty_->Read(ReadRule::kNewest, state_, arrival_);
    lost += result == ReadResult::kLost ? 1 : 0;
    command.message_id = state_.message_id;
    faulty_->Write(command);
  }
  const auto counts = guard.counts();
  EXPECT_EQ(counts, test::RealtimeGuard::Counts{});
  EXPECT_EQ(lost, 101);
  const FaultCounts& struck = faulty_->counts();
  EXPECT_GT(std::min({struck.states_lost, struck.commands_lost, struck.commands_duplicated,
                      struck.commands_swapped, struck.commands_delayed, struck.commands_garbage}),
            0u);
}

TEST_F(FaultyBackendTest, RefusesAPlanThatIsNotValid) {
  EXPECT_THROW(Make(PlanOf(&FaultPlan::command_garbage, {.probability = 2})), InputError);
}

}  // namespace
}  // namespace twin::backend::backend_faulty_backend_test
