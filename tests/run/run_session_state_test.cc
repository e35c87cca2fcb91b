#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "run/session_fixture.h"
#include "support/bits.h"
#include "twin/core/error.h"
#include "twin/run/session.h"

namespace twin::run::run_session_state_test {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

/// Keeps cycles and the times of all records.
class Timed final : public record::RecordSink {
 public:
  void Put(const record::CycleRecord& record) noexcept override {
    states.push_back(record.state);
    cycles.push_back(record.at);
  }
  void Put(const record::TickRecord& record) noexcept override { ticks.push_back(record.read); }

  std::vector<RobotState> states;
  std::vector<Time> cycles;
  std::vector<Time> ticks;
};

/// All that a state says, as bits.
std::vector<std::uint64_t> BitsOf(const std::vector<RobotState>& states, std::size_t from) {
  std::vector<std::uint64_t> bits;
  for (std::size_t i = from; i < states.size(); ++i) {
    const RobotState& state = states[i];
    bits.push_back(state.message_id);
    for (const JointVector* values : {&state.q, &state.dq, &state.tau_J, &state.q_d, &state.ddq_d,
                                      &state.tau_ext_hat_filtered, &state.tau_J_d}) {
      for (const double value : *values) bits.push_back(std::bit_cast<std::uint64_t>(value));
    }
    for (const double value : state.O_T_EE) bits.push_back(std::bit_cast<std::uint64_t>(value));
    bits.push_back(static_cast<std::uint64_t>(state.robot_mode));
  }
  return bits;
}

scenario::Scenario WithBox() {
  scenario::Scenario scenario = test::Standing();
  scenario.plant.kind = robot::PlantKind::kMujoco;
  scenario.plant.noise_q = 1e-6;
  scenario.scene = "scenes/table_box.xml";
  scenario.link.command.loss.law = scenario::IndependentLoss{1};
  return scenario;
}

class SessionStateTest : public test::SessionFixture {};

TEST_F(SessionStateTest, ARestoredTwinGivesTheSameBitsEachTime) {
  const scenario::Scenario scenario = WithBox();
  Timed log;
  const auto session = Open(scenario, &log);
  session->Begin();
  const auto snapshot_of_start = session->Save();
  const MotionResult there = session->Move(Turn(test::kRest, 0.1, *session, scenario, "there"));
  ASSERT_TRUE(there.report.succeeded()) << there.report.failure;
  const auto snapshot = session->Save();
  const Time saved = session->Now();
  const auto branch = [&] {
    const std::size_t from = log.states.size();
    const JointVector q = session->Peek().q_d;
    const MotionResult back = session->Move(Turn(q, -0.1, *session, scenario, "back"));
    EXPECT_TRUE(back.report.succeeded()) << back.report.failure;
    EXPECT_EQ(session->Command(hand::Move{.width = 0.04, .speed = 0.1}).result,
              HandResult::kSuccess);
    return BitsOf(log.states, from);
  };
  const std::vector<std::uint64_t> first = branch();
  ASSERT_GT(first.size(), 10'000u);
  for (int i = 0; i < 2; ++i) {
    session->Restore(*snapshot);
    EXPECT_EQ(session->Now(), saved);
    EXPECT_EQ(branch(), first) << "time " << i + 1;
  }
  // And from the first instant on, the whole session once more.
  const std::vector<std::uint64_t> whole = BitsOf(log.states, 0);
  const std::size_t from = log.states.size();
  session->Restore(*snapshot_of_start);
  static_cast<void>(session->Move(Turn(test::kRest, 0.1, *session, scenario, "there")));
  const std::vector<std::uint64_t> again = BitsOf(log.states, from);
  ASSERT_LT(again.size(), whole.size());
  EXPECT_TRUE(std::equal(again.begin(), again.end(), whole.begin()));
}

TEST_F(SessionStateTest, ItsResultIsThatOfASessionThatNeverWentElsewhere) {
  const scenario::Scenario scenario = WithBox();
  const auto result = [&](bool goes_elsewhere) {
    const auto session = Open(scenario);
    session->Begin();
    static_cast<void>(session->Move(Turn(test::kRest, 0.1, *session, scenario, "there")));
    const JointVector q = session->Peek().q_d;
    if (goes_elsewhere) {
      const auto snapshot = session->Save();
      session->Place("box", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0.5, 0.3, 1, 1});
      static_cast<void>(session->Move(Jump(q, *session, scenario)));
      session->Restore(*snapshot);
    }
    static_cast<void>(session->Move(Turn(q, -0.05, *session, scenario, "back")));
    return session->End();
  };
  const SessionResult straight = result(false);
  const SessionResult detour = result(true);
  EXPECT_EQ(detour.states_hash, straight.states_hash);
  EXPECT_EQ(detour.motions, straight.motions);
  EXPECT_EQ(detour.counts.served, straight.counts.served);
  EXPECT_EQ(detour.counts.held, straight.counts.held);
  EXPECT_EQ(detour.followed.size(), straight.followed.size());
}

TEST_F(SessionStateTest, TimesOfRecordsAndEventsRiseOverARestore) {
  const scenario::Scenario scenario = test::Standing();
  Timed log;
  std::vector<Time> events;
  RunHooks hooks;
  hooks.event = [&events](Time at, std::string_view, std::string_view) { events.push_back(at); };
  const auto session = Open(scenario, &log);
  session->Begin(hooks);
  const auto snapshot = session->Save();
  for (int i = 0; i < 3; ++i) {
    static_cast<void>(session->Move(Turn(test::kRest, 0.05, *session, scenario, "there")));
    session->Restore(*snapshot);
  }
  for (const std::vector<Time>* times : {&log.cycles, &log.ticks, &events}) {
    ASSERT_GT(times->size(), 5u);
    EXPECT_TRUE(std::ranges::is_sorted(*times));
  }
  EXPECT_NEAR(ToSeconds(log.cycles.back() - log.ticks.back()), 0, 1e-3);
}

TEST_F(SessionStateTest, ShowsTheStartBeforeTheFirstCycleAndChangesNothing) {
  const scenario::Scenario scenario = WithBox();
  const auto hash = [&](bool looks) {
    const auto session = Open(scenario);
    session->Begin();
    if (looks) {
      const RobotState state = session->Peek();
      EXPECT_EQ(state.message_id, 0u);
      EXPECT_EQ(state.robot_mode, RobotMode::kIdle);
      EXPECT_NEAR(state.q[3], test::kRest[3], 1e-4);
      EXPECT_NEAR(state.O_T_EE[12], 0.307, 1e-2);
      EXPECT_EQ(session->Now(), Time());
    }
    static_cast<void>(session->Move(Turn(test::kRest, 0.05, *session, scenario, "there")));
    return session->End().states_hash;
  };
  EXPECT_EQ(hash(true), hash(false));
}

TEST_F(SessionStateTest, PlacesAFreeBody) {
  const auto session = Open(WithBox());
  session->Begin();
  ASSERT_EQ(session->Bodies().size(), 1u);
  const auto [name, before] = session->Bodies().front();
  Transform X = before;
  X[13] += 0.1;
  session->Place(name, X);
  EXPECT_NEAR(session->Bodies().front().second[13], before[13] + 0.1, 1e-12);
  Transform under = X;
  under[14] -= 0.02;
  EXPECT_THAT([&] { session->Place(name, under); },
              ThrowsMessage<InputError>(HasSubstr("deep in")));
  EXPECT_THAT([&] { session->Place("ball", X); },
              ThrowsMessage<InputError>(HasSubstr("those that move freely: " + name)));
  Transform oblique = X;
  oblique[0] = 2;
  EXPECT_THAT([&] { session->Place(name, oblique); },
              ThrowsMessage<InputError>(HasSubstr("not rigid")));
  EXPECT_NEAR(session->Bodies().front().second[13], before[13] + 0.1, 1e-12);
}

TEST_F(SessionStateTest, ResetBringsArmHandAndBodiesBack) {
  const scenario::Scenario scenario = WithBox();
  const auto session = Open(scenario);
  session->Begin();
  const auto before = session->Bodies().front();
  ASSERT_EQ(session->Move(Jump(test::kRest, *session, scenario)).report.end,
            backend::MotionEnd::kAborted);
  Transform X = before.second;
  X[13] += 0.1;
  session->Place(before.first, X);
  const Time at = session->Now();
  JointVector q = test::kRest;
  q[6] += 0.2;
  session->Reset(q);
  EXPECT_GT(session->Now(), at);
  EXPECT_LT(session->Now(), at + std::chrono::milliseconds(20));
  const RobotState state = session->Peek();
  EXPECT_EQ(state.robot_mode, RobotMode::kIdle);
  EXPECT_NEAR(state.q_d[6], q[6], 1e-9);
  EXPECT_NEAR(session->Bodies().front().second[13], before.second[13], 1e-3);
  const MotionResult on = session->Move(Turn(q, 0.05, *session, scenario, "on"));
  EXPECT_TRUE(on.report.succeeded()) << on.report.failure;
  q[3] = 0.5;
  EXPECT_THAT([&] { session->Reset(q); }, ThrowsMessage<InputError>(HasSubstr("reset: joint 4")));
}

TEST_F(SessionStateTest, TheIdealPlantHasNoBodies) {
  const auto session = Open(test::Standing());
  session->Begin();
  EXPECT_TRUE(session->Bodies().empty());
  EXPECT_THAT([&] { session->Place("box", kIdentityTransform); },
              ThrowsMessage<InputError>(HasSubstr("ideal plant")));
}

TEST_F(SessionStateTest, AWaitThatIsLookedAtCanBeStopped) {
  const auto session = Open(test::Standing());
  volatile bool interrupted = false;
  int looks = 0;
  RunHooks hooks;
  hooks.interrupted = &interrupted;
  hooks.look = [&] { interrupted = interrupted || ++looks == 50; };
  session->Begin(hooks);
  const auto never = [](const RobotState& /*state*/) { return false; };
  EXPECT_EQ(session->Wait(std::chrono::hours(1), never), WaitEnd::kInterrupted);
  looks = 0;
  interrupted = false;
  EXPECT_EQ(session->Command(hand::Move{.width = 0.0, .speed = 0.001}).failure, "interrupted");
  looks = 0;
  interrupted = false;
  const scenario::Scenario scenario = test::Standing();
  Motion stand = Turn(test::kRest, 0.1, *session, scenario, "stand");
  stand.trajectory =
      StandingFor(session->Peek().q_d, std::chrono::hours(1), session->robot().limits);
  EXPECT_EQ(session->Move(stand).report.failure, "interrupted");
}

TEST_F(SessionStateTest, OtherDrivesRefuseWithTheCure) {
  scenario::Scenario realtime = test::Standing();
  realtime.drive = scenario::Drive::kRealtime;
  const auto session = Open(realtime);
  session->Begin();
  const auto refuses = [](const auto& call) {
    EXPECT_THAT(call, ThrowsMessage<InputError>(HasSubstr("drive: lockstep")));
  };
  refuses([&] { (void)session->Save(); });
  refuses([&] { (void)session->Peek(); });
  refuses([&] { (void)session->Bodies(); });
  refuses([&] { session->Reset(test::kRest); });
  refuses([&] { session->Place("box", kIdentityTransform); });
  const auto lockstep = Open(test::Standing());
  lockstep->Begin();
  const auto snapshot = lockstep->Save();
  refuses([&] { session->Restore(*snapshot); });
}

}  // namespace
}  // namespace twin::run::run_session_state_test
