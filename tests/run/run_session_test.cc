#include "support/bits.h"
#include "twin/run/session.h"

#include <algorithm>
#include <cstring>
#include <iterator>
#include <set>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "run/session_fixture.h"
#include "twin/core/error.h"

namespace twin::run::run_session_test {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

/// On the virtual clock.
class SessionTest : public test::SessionFixture {
 protected:
  /// Joint 1 there and back. @returns the session's fingerprint.
  std::uint64_t ThereAndBack(std::uint64_t seed, test::Log* log = nullptr) {
    scenario::Scenario scenario = test::Standing();
    scenario.seed = seed;
    const auto session = Open(scenario, log);
    session->Begin();
    GoThereAndBack(*session, scenario);
    return session->End().states_hash;
  }
};

TEST_F(SessionTest, RunsAMotionAHandCommandAndAMotionFromThere) {
  EXPECT_NE(ThereAndBack(1), 0u);
}

TEST_F(SessionTest, RepeatsWithTheSeed) {
  const std::uint64_t first = ThereAndBack(1);
  EXPECT_EQ(ThereAndBack(1), first);
  EXPECT_NE(ThereAndBack(2), first);
}

TEST_F(SessionTest, BeginsAsARunOfItsFirstMotionDoes) {
  const scenario::Scenario scenario = test::Standing();
  test::Log alone;
  run::Run run(scenario, {backends_, controllers_}, files_, &alone);
  static_cast<void>(run.Execute());
  test::Log log;
  const auto session = Open(scenario, &log);
  session->Begin();
  GoThereAndBack(*session, scenario);
  ASSERT_GT(alone.cycles.size(), 500u);
  ASSERT_GT(log.cycles.size(), alone.cycles.size());
  for (std::size_t i = 0; i < alone.cycles.size(); ++i) {
    ASSERT_EQ(test::Bits(alone.cycles[i].q_d), test::Bits(log.cycles[i].q_d)) << i;
    ASSERT_EQ(alone.cycles[i].message_id, log.cycles[i].message_id);
  }
}

TEST_F(SessionTest, DrawsOtherNumbersInASecondMotion) {
  scenario::Scenario scenario = test::Standing();
  scenario.controller.target_noise = 1e-9;
  test::Log log;
  const auto session = Open(scenario, &log);
  session->Begin();
  std::vector<std::set<double>> targets;
  for (int i = 0; i < 2; ++i) {
    Motion stand = Turn(test::kRest, 0.1, *session, scenario, "stand");
    stand.trajectory =
        StandingFor(test::kRest, std::chrono::milliseconds(300), session->robot().limits);
    log.targets.clear();
    static_cast<void>(session->Move(stand));
    targets.emplace_back(log.targets.begin(), log.targets.end());
  }
  ASSERT_GT(targets[0].size(), 200u);
  ASSERT_GT(targets[1].size(), 200u);
  std::vector<double> common;
  std::ranges::set_intersection(targets[0], targets[1], std::back_inserter(common));
  EXPECT_LT(common.size(), 5u);
}

TEST_F(SessionTest, GoesOnAfterAReflexOnceRecovered) {
  const scenario::Scenario scenario = test::Standing();
  const auto session = Open(scenario);
  session->Begin();
  FailAndRecover(*session, scenario);
  session->Recover();  // nothing to recover from
}

TEST_F(SessionTest, RefusesAMotionBeforeTheRobotHasRecovered) {
  const scenario::Scenario scenario = test::Standing();
  const auto session = Open(scenario);
  session->Begin();
  ASSERT_EQ(session->Move(Jump(test::kRest, *session, scenario)).report.end,
            backend::MotionEnd::kAborted);
  const JointVector q = session->ReadState().q_d;
  EXPECT_THROW((void)session->Move(Turn(q, 0.05, *session, scenario, "too early")), RobotFault);
}

TEST_F(SessionTest, CountsCyclesPerMotionAndInAll) {
  const scenario::Scenario scenario = test::Standing();
  test::Log log;
  const auto session = Open(scenario, &log);
  session->Begin();
  const MotionResult there = session->Move(Turn(test::kRest, 0.1, *session, scenario, "there"));
  const JointVector q = session->ReadState().q_d;
  const MotionResult on = session->Move(Turn(q, 0.05, *session, scenario, "on"));
  const SessionResult all = session->End();
  EXPECT_EQ(all.motions, 2u);
  EXPECT_GT(there.counts.served, 100u);
  EXPECT_GT(there.counts.served, on.counts.served);
  EXPECT_EQ(all.counts.served, there.counts.served + on.counts.served);
  EXPECT_GE(log.ticks, all.counts.served);
}

TEST_F(SessionTest, TellsWhichMotionRuns) {
  const scenario::Scenario scenario = test::Standing();
  const auto session = Open(scenario);
  std::vector<std::string> lines;
  RunHooks hooks;
  hooks.event = [&lines](Time, std::string_view kind, std::string_view text) {
    lines.push_back(std::string(kind) + ": " + std::string(text));
  };
  session->Begin(hooks);
  GoThereAndBack(*session, scenario);
  EXPECT_THAT(lines, Contains(HasSubstr("session: motion 1: there")));
  EXPECT_THAT(lines, Contains(HasSubstr("hand: Move: success")));
  EXPECT_THAT(lines, Contains(HasSubstr("session: motion 2: back")));
}

TEST_F(SessionTest, RefusesAMotionThatBeginsElsewhere) {
  const scenario::Scenario scenario = test::Standing();
  const auto session = Open(scenario);
  session->Begin();
  JointVector elsewhere = test::kRest;
  elsewhere[0] += 0.3;
  EXPECT_THROW((void)session->Move(Turn(elsewhere, 0.1, *session, scenario, "x")), InputError);
}

TEST_F(SessionTest, AnInterruptEndsEverythingSoon) {
  const scenario::Scenario scenario = test::Standing();
  const auto session = Open(scenario);
  volatile bool interrupted = false;
  RunHooks hooks;
  hooks.interrupted = &interrupted;
  session->Begin(hooks);
  interrupted = true;
  const MotionResult motion = session->Move(Turn(test::kRest, 0.1, *session, scenario, "x"));
  EXPECT_EQ(motion.report.failure, "interrupted");
  EXPECT_EQ(session->Command(hand::Move{.width = 0.04, .speed = 0.1}).failure, "interrupted");
  EXPECT_EQ(session->WaitForRest(), WaitEnd::kInterrupted);
  EXPECT_LT(session->Now(), Time(std::chrono::seconds(1)));
}

TEST_F(SessionTest, StopsAHandThatTakesTooLong) {
  const scenario::Scenario scenario = test::Standing();
  const auto session = Open(scenario);
  session->Begin();
  const HandOutcome outcome =
      session->Command(hand::Move{.width = 0.0, .speed = 0.001}, std::chrono::milliseconds(200));
  EXPECT_THAT(outcome.failure, HasSubstr("has not ended within 0.2 s"));
  EXPECT_EQ(outcome.result, HandResult::kAborted);
}

TEST_F(SessionTest, GivesUpWaitingAtItsLimit) {
  const scenario::Scenario scenario = test::Standing();
  const auto session = Open(scenario);
  session->Begin();
  EXPECT_EQ(session->Wait(std::chrono::milliseconds(50), [](const RobotState&) { return false; }),
            WaitEnd::kTimeLimit);
  EXPECT_GE(session->Now(), Time(std::chrono::milliseconds(50)));
}

TEST_F(SessionTest, NeedsNoMotionOfTheScenariosButAPlaceToRest) {
  scenario::Scenario scenario = test::Standing();
  scenario.motion.waypoints.clear();
  EXPECT_THAT([&] { (void)Open(scenario); }, ThrowsMessage<InputError>(HasSubstr("robot.q_start")));
  scenario.robot.q_start = test::kRest;
  EXPECT_NO_THROW((void)Open(scenario));
}

/// Campaign, worlds 353190, 356726, 357246, 364968: it was flung apart in its first cycle.
TEST_F(SessionTest, AnArmDoesNotStartWithinItself) {
  scenario::Scenario scenario = test::Standing();
  scenario.motion.waypoints.clear();
  scenario.plant.kind = robot::PlantKind::kMujoco;
  scenario.robot.q_start = {-0.2088, -0.3707, 0.3834, -2.9844, -0.3372, 0.9397, 0.2327};
  EXPECT_THAT([&] { (void)Open(scenario); },
              ThrowsMessage<InputError>(HasSubstr("mm deep in panda_")));
  scenario.robot.q_start = test::kRest;
  EXPECT_NO_THROW((void)Open(scenario));
}

}  // namespace
}  // namespace twin::run::run_session_test
