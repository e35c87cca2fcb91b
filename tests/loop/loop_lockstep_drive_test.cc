#include "twin/loop/lockstep_drive.h"

#include <chrono>
#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "plugins/mujoco/mujoco_backend.h"
#include "support/panda_limits.h"
#include "support/realtime_guard.h"
#include "twin/core/error.h"

namespace twin::loop {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using std::chrono::seconds;

/// Moves joint 7 by 0.3 rad and back along a smooth curve of 1 s, then is done.
class Swing final : public control::Controller {
 public:
  control::CommandInterface command_interface() const noexcept override {
    return control::CommandInterface::kJointPosition;
  }
  void Activate(const RobotState& state, Time) override {
    if (refuses) throw InputError("this controller does not want to start");
    start_ = state.q_d;
    begin_ = Time::min();
  }
  void Update(const RobotState&, Time now, control::ControllerOutput& output) noexcept override {
    if (begin_ == Time::min()) begin_ = now;
    const double s = std::min(ToSeconds(now - begin_), 1.0);
    const double bump = s * s * s * s * (1 - s) * (1 - s) * (1 - s) * (1 - s) * 256;
    output.target.q = start_;
    output.target.q[6] += 0.3 * bump;
    output.finished = s >= 1.0 && !endless;
  }
  void Deactivate() noexcept override { ++deactivated; }

  bool refuses = false;
  bool endless = false;
  int deactivated = 0;

 private:
  JointVector start_{};
  Time begin_ = Time::min();
};

/// Keeps every record, so that runs can be compared to the bit.
class Keeper final : public rt::RecordSink {
 public:
  void Put(const rt::CycleRecord& record) noexcept override { cycles.push_back(record); }
  void Put(const rt::TickRecord& record) noexcept override { ticks.push_back(record); }

  std::vector<rt::CycleRecord> cycles;
  std::vector<rt::TickRecord> ticks;
};

class LockstepDriveTest : public ::testing::Test {
 protected:
  LockstepDriveTest() {
    robot_.onboard.limits = test::PandaLimits();
    robot_.plant_kind = robot::PlantKind::kIdeal;
    robot_.link.state_delay = rt::DelayModel(rt::LogNormalDelay{microseconds(60), 0.3, {}});
    robot_.link.command_delay = rt::DelayModel(rt::LogNormalDelay{microseconds(60), 0.3, {}});
    robot_.q_start = {0, -0.785398163397, 0, -2.356194490192, 0, 1.570796326795, 0.785398163397};
    tick_.cost = rt::DelayModel(rt::LogNormalDelay{microseconds(13), 0.4, {}});
    controller_.cost = rt::DelayModel(rt::ConstantDelay{microseconds(200)});
    controller_.clock_ppm = 50;
  }

  RunReport Run(std::uint64_t seed = 1, Keeper* keeper = nullptr) {
    robot_.seed = seed;
    rt::EventQueue events;
    LockstepDrive drive;
    backend::Registry registry;
    plugins::RegisterMujoco(registry);
    const backend::Connection connection =
        registry.Find("mujoco")({robot_, events, drive.StateReady(), keeper});
    return drive.Run({events,
                      *connection.backend,
                      swing_,
                      MotionModes{},
                      tick_,
                      controller_,
                      seed,
                      time_limit_,
                      keeper,
                      {},
                      {},
                      interrupted_});
  }

  robot::RobotConfig robot_;
  TickConfig tick_;
  ControllerLoopConfig controller_;
  Duration time_limit_ = seconds(20);
  const volatile bool* interrupted_ = nullptr;
  Swing swing_;
};

TEST_F(LockstepDriveTest, RunsAMotionToItsEnd) {
  const RunReport report = Run();
  EXPECT_EQ(report.end, backend::MotionEnd::kSuccess) << report.failure;
  EXPECT_TRUE(report.failure.empty());
  EXPECT_GT(report.written, 1000u);
  EXPECT_NEAR(report.q_final[6], robot_.q_start[6], 2e-4);
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
  std::size_t served = 0;
  std::size_t held = 0;
  for (const rt::CycleRecord& cycle : keeper.cycles) {
    served += cycle.fate == rt::CommandFate::kServed ? 1 : 0;
    held += cycle.fate == rt::CommandFate::kHeld ? 1 : 0;
  }
  EXPECT_GT(served, 1000u);
  EXPECT_EQ(held, 0u);
}

TEST_F(LockstepDriveTest, SurvivesLossInBothDirections) {
  robot_.link.command_loss = 0.02;
  robot_.link.state_loss = 0.02;
  const RunReport report = Run(3);
  EXPECT_EQ(report.end, backend::MotionEnd::kSuccess) << report.failure;
  EXPECT_GT(report.skipped_states, 0u);
}

TEST_F(LockstepDriveTest, ALinkThatAlwaysMissesTheDeadlineNeverGetsACommandThrough) {
  robot_.link.command_delay = rt::DelayModel(rt::ConstantDelay{microseconds(950)});
  const RunReport report = Run();
  EXPECT_EQ(report.end, backend::MotionEnd::kAborted);
  EXPECT_TRUE(
      report.errors[static_cast<std::size_t>(RobotError::kCommunicationConstraintsViolation)]);
}

TEST_F(LockstepDriveTest, AMotionThatOutlastsItsTimeIsStoppedAndSaidSo) {
  swing_.endless = true;
  time_limit_ = milliseconds(500);
  const RunReport report = Run();
  EXPECT_EQ(report.end, backend::MotionEnd::kPreempted);
  EXPECT_NE(report.failure.find("did not end within 0.5 s"), std::string::npos) << report.failure;
}

TEST_F(LockstepDriveTest, AnInterruptStopsTheArm) {
  swing_.endless = true;
  const volatile bool interrupted = true;
  interrupted_ = &interrupted;
  const RunReport report = Run();
  EXPECT_NE(report.end, backend::MotionEnd::kSuccess);
}

TEST_F(LockstepDriveTest, AControllerThatRefusesToStartStartsNoMotion) {
  swing_.refuses = true;
  Keeper keeper;
  EXPECT_THROW(static_cast<void>(Run(1, &keeper)), InputError);
  for (const rt::CycleRecord& cycle : keeper.cycles) {
    EXPECT_EQ(cycle.state.robot_mode, RobotMode::kIdle);
  }
}

TEST_F(LockstepDriveTest, AnEndThatNoStateTellsOfIsNoticed) {
  // Hardly a state comes through: the robot aborts for want of commands, and nobody tells.
  robot_.link.state_loss = 0.999;
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

TEST_F(LockstepDriveTest, ALinkThatLosesEveryStateIsReported) {
  robot_.link.state_loss = 1;
  EXPECT_THROW(static_cast<void>(Run()), RobotFault);
}

/// Counts what the thread allocates and locks over 10 000 cycles of a running motion.
class GuardedSink final : public rt::RecordSink {
 public:
  static constexpr int kFirst = 100;
  static constexpr int kCycles = 10000;

  void Put(const rt::CycleRecord&) noexcept override {
    ++cycles_;
    if (cycles_ == kFirst) start_ = guard_.counts();
    if (cycles_ == kFirst + kCycles) end_ = guard_.counts();
  }
  void Put(const rt::TickRecord&) noexcept override {}

  test::RealtimeGuard guard_;
  int cycles_ = 0;
  test::RealtimeGuard::Counts start_, end_;
};

TEST_F(LockstepDriveTest, AllocatesAndLocksNothingInTenThousandCyclesOfTheWholeChain) {
  robot_.plant_kind = robot::PlantKind::kMujoco;
  robot_.plant.urdf = TWIN_SOURCE_DIR "/models/robots/panda/panda.urdf";
  robot_.plant.hand = plant::HandKind::kNone;
  robot_.onboard.rotor_inertia.fill(0.3);
  swing_.endless = true;
  GuardedSink sink;
  rt::EventQueue events;
  LockstepDrive drive;
  backend::Registry registry;
  plugins::RegisterMujoco(registry);
  const backend::Connection connection =
      registry.Find("mujoco")({robot_, events, drive.StateReady(), &sink});
  const RunReport report = drive.Run({events,
                                      *connection.backend,
                                      swing_,
                                      MotionModes{},
                                      tick_,
                                      controller_,
                                      1,
                                      seconds(11),
                                      &sink,
                                      {},
                                      {},
                                      nullptr});
  EXPECT_EQ(report.end, backend::MotionEnd::kPreempted) << report.failure;
  ASSERT_GT(sink.cycles_, GuardedSink::kFirst + GuardedSink::kCycles);
  EXPECT_EQ(sink.end_.allocations - sink.start_.allocations, 0);
  EXPECT_EQ(sink.end_.frees - sink.start_.frees, 0);
  EXPECT_EQ(sink.end_.locks - sink.start_.locks, 0);
}

}  // namespace
}  // namespace twin::loop
