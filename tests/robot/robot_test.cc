#include "twin/robot/robot.h"

#include <chrono>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "robot/robot_fixture.h"
#include "twin/core/error.h"

namespace twin::robot::robot_test {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using std::chrono::seconds;

/// The workstation's end of a robot: answers every state after a fixed time.
class Workstation final : public rt::EventHandler {
 public:
  void OnEvent(Time now, std::uint64_t id) noexcept override {
    if (answer_after >= Duration::zero() && id > 3) {
      events->Schedule(now + answer_after, rt::EventOrder::kTickDone, answer, id);
    }
  }

  class Answer final : public rt::EventHandler {
   public:
    void OnEvent(Time, std::uint64_t id) noexcept override {
      RobotCommand command;
      command.message_id = id;
      command.q_c = test::kReady;
      robot->Send(command);
    }
    Robot* robot = nullptr;
  };

  rt::EventQueue* events = nullptr;
  Answer answer;
  Duration answer_after{-1};
};

/// Keeps the last cycle.
class LastCycle final : public record::RecordSink {
 public:
  void Put(const record::CycleRecord& record) noexcept override { last = record; }
  void Put(const record::TickRecord&) noexcept override {}
  record::CycleRecord last;
};

/// Keeps the steps before which it was told of a motion.
class AttentivePlant final : public plant::Plant {
 public:
  explicit AttentivePlant(std::vector<std::uint64_t>& told) : told_(told) {}
  void Reset(const JointVector& q) override { body_.Reset(q); }
  std::unique_ptr<const State> Save() const override { return body_.Save(); }
  void Restore(const State& state) override { body_.Restore(state); }
  void Step(const JointDrive& drive) noexcept override {
    ++steps_;
    body_.Step(drive);
  }
  void BeginMotion() noexcept override { told_.push_back(steps_); }
  [[nodiscard]] const JointSensors& sensors() const noexcept override { return body_.sensors(); }

 private:
  plant::IdealPlant body_;
  std::vector<std::uint64_t>& told_;
  std::uint64_t steps_ = 0;
};

class RobotTest : public ::testing::Test {
 protected:
  void Make(const RobotConfig& config, std::unique_ptr<plant::Plant> plant) {
    robot_ = std::make_unique<Robot>(config, std::move(plant), events_, workstation_, &cycle_);
    robot_->Begin();
    workstation_.events = &events_;
    workstation_.answer.robot = robot_.get();
  }
  void RunFor(Duration duration) {
    const Time until = events_.Now() + duration;
    while (events_.Now() < until) ASSERT_TRUE(events_.RunNext());
  }

  rt::EventQueue events_;
  Workstation workstation_;
  LastCycle cycle_;
  std::unique_ptr<Robot> robot_;
};

TEST_F(RobotTest, SendsOneStateEveryMillisecond) {
  Make(test::PandaRobot(), std::make_unique<plant::IdealPlant>());
  RunFor(milliseconds(50));
  EXPECT_EQ(cycle_.last.state.message_id, 50u);
  EXPECT_EQ(cycle_.last.at, Time(milliseconds(50)));
}

TEST_F(RobotTest, TakesACommandThatArrivesExactlyAtTheDeadlineAndDropsALaterOne) {
  // Round trip: 80 us + answer + 80 us; deadline: 1000 us - d_INT.
  for (const int late_ns : {0, 1}) {
    RobotConfig config = test::PandaRobot();
    config.link.d_INT = microseconds(100);
    workstation_ = Workstation();
    workstation_.answer_after = microseconds(1000 - 100 - 160) + Duration(late_ns);
    events_ = rt::EventQueue();
    Make(config, std::make_unique<plant::IdealPlant>());
    ASSERT_EQ(robot_->Move({}), MoveStatus::kMotionStarted);
    RunFor(milliseconds(20));
    EXPECT_EQ(cycle_.last.fate,
              late_ns == 0 ? record::CommandFate::kServed : record::CommandFate::kNone);
    EXPECT_EQ(cycle_.last.dropped, late_ns == 0 ? 0u : 1u);
  }
}

TEST_F(RobotTest, TellsThePlantOfEachMotionInTheCycleThatTakesItsFirstCommand) {
  std::vector<std::uint64_t> told;
  Make(test::PandaRobot(), std::make_unique<AttentivePlant>(told));
  const auto in_motion = [this] { return robot_->mode() == RobotMode::kMove; };
  // A motion that nobody answers is none for the plant.
  ASSERT_EQ(robot_->Move({}), MoveStatus::kMotionStarted);
  RunFor(milliseconds(50));
  robot_->StopMove();
  RunFor(milliseconds(10));
  ASSERT_FALSE(in_motion());
  EXPECT_TRUE(told.empty());
  workstation_.answer_after = microseconds(100);
  std::vector<std::uint64_t> first_served;
  for (int motion = 0; motion < 2; ++motion) {
    ASSERT_EQ(robot_->Move({}), MoveStatus::kMotionStarted);
    do {
      RunFor(milliseconds(1));
    } while (cycle_.last.fate != record::CommandFate::kServed && in_motion());
    first_served.push_back(cycle_.last.state.message_id);
    RunFor(milliseconds(30));
    robot_->StopMove();
    RunFor(milliseconds(10));
    ASSERT_FALSE(in_motion());
  }
  // Told before the step whose state is the first that followed a command.
  EXPECT_EQ(told, (std::vector<std::uint64_t>{first_served[0] - 1, first_served[1] - 1}));
}

TEST_F(RobotTest, CyclesFallOnWholeMillisecondsWhenNoClockDrifts) {
  Make(test::PandaRobot(), std::make_unique<plant::IdealPlant>());
  for (int k = 1; k <= 2000; ++k) {
    RunFor(milliseconds(1));
    ASSERT_EQ(cycle_.last.at, Time(milliseconds(k)));
  }
}

TEST_F(RobotTest, AClockThatDriftsMovesEveryCycleByItsShare) {
  for (const double ppm : {54.6, -54.6, 1000.0, -1000.0}) {
    RobotConfig config = test::PandaRobot();
    config.clock_ppm = ppm;
    events_ = rt::EventQueue();
    cycle_ = LastCycle();
    Make(config, std::make_unique<plant::IdealPlant>());
    while (cycle_.last.state.message_id < 18320) {
      ASSERT_TRUE(events_.RunNext());
      // INT's own clock shows k ms in cycle k; the queue's counts whole nanoseconds.
      const double own_ms = ToSeconds(cycle_.last.at.time_since_epoch()) * (1 + ppm * 1e-6) * 1e3;
      ASSERT_NEAR(own_ms, static_cast<double>(cycle_.last.state.message_id), 0.6e-6) << ppm;
    }
  }
}

TEST_F(RobotTest, APostponedCycleKeepsItsIdAndTheGrid) {
  for (const double ppm : {0.0, 300.0}) {
    RobotConfig config = test::PandaRobot();
    config.clock_ppm = ppm;
    events_ = rt::EventQueue();
    Make(config, std::make_unique<plant::IdealPlant>());
    RunFor(milliseconds(10) - microseconds(500));
    const Time before = cycle_.last.at;
    const std::uint64_t id = cycle_.last.state.message_id;
    const Duration period = robot_->period();
    robot_->Postpone(4 * period);
    robot_->Postpone(2 * period);
    RunFor(milliseconds(8));
    EXPECT_EQ(cycle_.last.state.message_id, id + 2) << "cycles 7 and 8 periods after the last";
    EXPECT_NEAR(ToSeconds(cycle_.last.at - before), ToSeconds(8 * period), 10e-9);
    EXPECT_EQ(robot_->next_cycle(), cycle_.last.at + period);
  }
}

TEST_F(RobotTest, APostponedCycleTakesTheCommandThatArrivedMeanwhile) {
  RobotConfig config = test::PandaRobot();
  Make(config, std::make_unique<plant::IdealPlant>());
  ASSERT_EQ(robot_->Move({}), MoveStatus::kMotionStarted);
  RunFor(milliseconds(5));
  robot_->Postpone(3 * kCycle);
  RobotCommand command;
  command.message_id = cycle_.last.state.message_id;
  command.q_c = test::kReady;
  while (events_.Now() < Time(milliseconds(6))) ASSERT_TRUE(events_.RunNext());
  robot_->Send(command);  // too late for a cycle at 6 ms, in time for one at 9 ms
  while (events_.Now() < Time(milliseconds(9))) ASSERT_TRUE(events_.RunNext());
  EXPECT_EQ(cycle_.last.at, Time(milliseconds(9)));
  EXPECT_EQ(cycle_.last.state.message_id, 6u);
  EXPECT_EQ(cycle_.last.fate, record::CommandFate::kServed);
}

TEST_F(RobotTest, HoldsStillAtRestForTenSeconds) {
  const RobotConfig config = test::PandaRobot();
  Make(config, plant::MujocoPlant::Create(config.plant));
  RunFor(seconds(10));
  for (std::size_t i = 0; i < kJoints; ++i) {
    EXPECT_NEAR(cycle_.last.state.q[i], test::kReady[i], 1e-4) << "joint " << i + 1;
  }
}

TEST_F(RobotTest, HoldsStillWithTheHandMounted) {
  RobotConfig config = test::PandaRobot();
  config.plant.hand = plant::HandKind::kFrankaHand;
  config.onboard.end_effector = {0.73, {-0.01, 0, 0.03}, {0.001, 0, 0, 0, 0.0025, 0, 0, 0, 0.0017}};
  Make(config, plant::MujocoPlant::Create(config.plant));
  RunFor(seconds(2));
  for (std::size_t i = 0; i < kJoints; ++i) {
    EXPECT_NEAR(cycle_.last.state.q[i], test::kReady[i], 1e-4) << "joint " << i + 1;
  }
}

TEST_F(RobotTest, RefusesAStartOutsideTheJointRange) {
  RobotConfig config = test::PandaRobot();
  config.q_start[3] = 0.5;
  try {
    Make(config, std::make_unique<plant::IdealPlant>());
    FAIL() << "accepted";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("joint 4"), std::string::npos) << error.what();
  }
}

TEST_F(RobotTest, RefusesALinkOutOfRangeByName) {
  RobotConfig config = test::PandaRobot();
  config.link.command.duplication = 1.5;
  try {
    Make(config, std::make_unique<plant::IdealPlant>());
    FAIL() << "accepted";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("link.command.duplication"), std::string::npos)
        << error.what();
  }
}

TEST_F(RobotTest, RefusesAClockThatIsTooFarOff) {
  for (const double ppm : {-1001.0, 1000.5, std::numeric_limits<double>::quiet_NaN()}) {
    RobotConfig config = test::PandaRobot();
    config.clock_ppm = ppm;
    EXPECT_THROW(config.Validate(), InputError) << ppm;
  }
  RobotConfig config = test::PandaRobot();
  config.clock_ppm = 1000;
  EXPECT_NO_THROW(config.Validate());
}

}  // namespace
}  // namespace twin::robot::robot_test
