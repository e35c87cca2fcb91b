#include "twin/loop/drive.h"

#include <chrono>
#include <string>

#include <gtest/gtest.h>

#include "loop/loop_fixture.h"
#include "support/realtime_guard.h"
#include "twin/core/error.h"

namespace twin::loop::loop_lockstep_drive_test {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using std::chrono::seconds;

using test::Keeper;

class LockstepDriveTest : public ::testing::Test {
 protected:
  LockstepDriveTest() {
    motion_.tick.cost = faults::DelayModel(faults::LogNormalDelay{microseconds(13), 0.4, {}});
    motion_.controller_loop.cost = faults::DelayModel(faults::ConstantDelay{microseconds(200)});
    motion_.controller_loop.clock_ppm = 50;
  }

  RunReport Run(std::uint64_t seed = 1, Keeper* keeper = nullptr) {
    return motion_.Run(swing_, seed, keeper);
  }

  test::LockstepMotion motion_;
  test::Swing swing_;
};

TEST_F(LockstepDriveTest, RunsAMotionToItsEnd) {
  const RunReport report = Run();
  EXPECT_EQ(report.end, backend::MotionEnd::kSuccess) << report.failure;
  EXPECT_TRUE(report.failure.empty());
  EXPECT_GT(report.timings.written, 1000u);
  EXPECT_NEAR(report.q_final[6], motion_.robot.q_start[6], 2e-4);
  EXPECT_EQ(swing_.deactivated, 1);
}

TEST_F(LockstepDriveTest, SameSeedGivesTheSameRecordsAndAnotherSeedOthers) {
  Keeper first, second, other;
  static_cast<void>(Run(1, &first));
  static_cast<void>(Run(1, &second));
  static_cast<void>(Run(2, &other));
  ASSERT_EQ(first.cycles.size(), second.cycles.size());
  ASSERT_EQ(first.ticks.size(), second.ticks.size());
  for (std::size_t i = 0; i < first.cycles.size(); ++i) {
    EXPECT_EQ(first.cycles[i].state.q_d, second.cycles[i].state.q_d);
    EXPECT_EQ(first.cycles[i].state.tau_J, second.cycles[i].state.tau_J);
    EXPECT_EQ(first.cycles[i].fate, second.cycles[i].fate);
  }
  bool differs = false;
  for (std::size_t i = 0; i < first.ticks.size(); ++i) {
    EXPECT_EQ(first.ticks[i].read, second.ticks[i].read);
    EXPECT_EQ(first.ticks[i].written, second.ticks[i].written);
    EXPECT_EQ(first.ticks[i].command.q_c, second.ticks[i].command.q_c);
    differs = differs || (i < other.ticks.size() && first.ticks[i].read != other.ticks[i].read);
  }
  EXPECT_TRUE(differs);
}

TEST_F(LockstepDriveTest, OnceRunningEveryCycleIsServed) {
  Keeper keeper;
  static_cast<void>(Run(1, &keeper));
  EXPECT_GT(keeper.Count(record::CommandFate::kServed), 1000u);
  EXPECT_EQ(keeper.Count(record::CommandFate::kHeld), 0u);
}

TEST_F(LockstepDriveTest, SurvivesLossInBothDirections) {
  motion_.robot.link.command.loss = faults::LossModel(faults::IndependentLoss{0.02});
  motion_.robot.link.state.loss = faults::LossModel(faults::IndependentLoss{0.02});
  const RunReport report = Run(3);
  EXPECT_EQ(report.end, backend::MotionEnd::kSuccess) << report.failure;
  EXPECT_GT(report.timings.skipped_states, 0u);
}

TEST_F(LockstepDriveTest, ALinkThatAlwaysMissesTheDeadlineNeverGetsACommandThrough) {
  motion_.robot.link.command.delay = faults::DelayModel(faults::ConstantDelay{microseconds(950)});
  const RunReport report = Run();
  EXPECT_EQ(report.end, backend::MotionEnd::kAborted);
  EXPECT_TRUE(
      report.errors[static_cast<std::size_t>(RobotError::kCommunicationConstraintsViolation)]);
}

TEST_F(LockstepDriveTest, AMotionThatOutlastsItsTimeIsStoppedAndSaidSo) {
  swing_.endless = true;
  motion_.time_limit = milliseconds(500);
  const RunReport report = Run();
  EXPECT_EQ(report.end, backend::MotionEnd::kPreempted);
  EXPECT_NE(report.failure.find("did not end within 0.5 s"), std::string::npos) << report.failure;
}

TEST_F(LockstepDriveTest, AnInterruptStopsTheArm) {
  swing_.endless = true;
  const volatile bool interrupted = true;
  motion_.interrupted = &interrupted;
  const RunReport report = Run();
  EXPECT_NE(report.end, backend::MotionEnd::kSuccess);
}

TEST_F(LockstepDriveTest, WhoeverAttendsIsCalledAtTheTimesHeAsksFor) {
  std::vector<Time> called;
  motion_.attend = [&called](Time now) {
    called.push_back(now);
    return called.size() < 4 ? now + milliseconds(100) : Time::max();
  };
  const RunReport report = Run();
  EXPECT_EQ(report.end, backend::MotionEnd::kSuccess) << report.failure;
  ASSERT_EQ(called.size(), 4u) << "and no more";
  EXPECT_EQ(called.front(), Time());
  for (std::size_t i = 1; i < called.size(); ++i) {
    EXPECT_GE(called[i] - called[i - 1], milliseconds(100));
    EXPECT_LE(called[i] - called[i - 1], milliseconds(101)) << "a cycle is never far";
  }
}

TEST_F(LockstepDriveTest, AControllerThatRefusesToStartStartsNoMotion) {
  swing_.refuses = true;
  Keeper keeper;
  EXPECT_THROW(static_cast<void>(Run(1, &keeper)), InputError);
  for (const record::CycleRecord& cycle : keeper.cycles) {
    EXPECT_EQ(cycle.state.robot_mode, RobotMode::kIdle);
  }
}

TEST_F(LockstepDriveTest, AnEndThatNoStateTellsOfIsNoticed) {
  // Hardly a state comes through: the robot aborts for want of commands, and nobody tells.
  motion_.robot.link.state.loss = faults::LossModel(faults::IndependentLoss{0.999});
  bool aborted = false;
  for (std::uint64_t seed = 1; seed <= 20 && !aborted; ++seed) {
    try {
      const RunReport report = Run(seed);
      aborted = report.end == backend::MotionEnd::kAborted;
      if (aborted) {
        EXPECT_NE(report.failure.find("communication_constraints_violation"), std::string::npos)
            << report.failure;
        EXPECT_LT(report.simulated, seconds(10)) << "it waited for its time limit";
      }
    } catch (const RobotFault&) {
      // not even a first state within 3 s
    }
  }
  EXPECT_TRUE(aborted);
}

TEST_F(LockstepDriveTest, StatesThatStopSayNothingOfTheArmsRest) {
  motion_.robot.link.state.loss = faults::LossModel(faults::ScriptedLoss{{{700, 100'000}}});
  const RunReport report = Run();
  EXPECT_EQ(report.end, backend::MotionEnd::kAborted);
  EXPECT_NE(report.failure.find("the robot's states have stopped"), std::string::npos)
      << report.failure;
  EXPECT_EQ(report.failure.find("still moves"), std::string::npos) << report.failure;
}

TEST_F(LockstepDriveTest, ALinkThatLosesEveryStateIsReported) {
  motion_.robot.link.state.loss = faults::LossModel(faults::IndependentLoss{1});
  EXPECT_THROW(static_cast<void>(Run()), RobotFault);
}

/// Counts what the thread allocates and locks over 10 000 cycles of a running motion.
class GuardedSink final : public record::RecordSink {
 public:
  static constexpr int kFirst = 100;
  static constexpr int kCycles = 10000;

  void Put(const record::CycleRecord&) noexcept override {
    ++cycles_;
    if (cycles_ == kFirst) start_ = guard_.counts();
    if (cycles_ == kFirst + kCycles) end_ = guard_.counts();
  }
  void Put(const record::TickRecord&) noexcept override {}

  test::RealtimeGuard guard_;
  int cycles_ = 0;
  test::RealtimeGuard::Counts start_, end_;
};

TEST_F(LockstepDriveTest, AllocatesAndLocksNothingInTenThousandCyclesOfTheWholeChain) {
  motion_.robot.plant_kind = robot::PlantKind::kMujoco;
  motion_.robot.plant.urdf = TWIN_SOURCE_DIR "/models/robots/panda/panda.urdf";
  motion_.robot.plant.hand = plant::HandKind::kNone;
  motion_.robot.onboard.rotor_inertia.fill(0.3);
  swing_.endless = true;
  GuardedSink sink;
  motion_.time_limit = seconds(11);
  const RunReport report = motion_.Run(swing_, 1, &sink);
  EXPECT_EQ(report.end, backend::MotionEnd::kPreempted) << report.failure;
  ASSERT_GT(sink.cycles_, GuardedSink::kFirst + GuardedSink::kCycles);
  EXPECT_EQ(sink.end_.allocations - sink.start_.allocations, 0);
  EXPECT_EQ(sink.end_.frees - sink.start_.frees, 0);
  EXPECT_EQ(sink.end_.locks - sink.start_.locks, 0);
}

}  // namespace
}  // namespace twin::loop::loop_lockstep_drive_test
