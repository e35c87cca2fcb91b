// The communication's ticks and the robot's cycles under RealtimeSanitizer: a call that allocates,
// locks, sleeps or does input and output ends the program.
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "loop/loop_fixture.h"
#include "twin/loop/asynchronous_loop.h"
#include "twin/loop/controller_loop.h"
#include "twin/plant/ideal_plant.h"
#include "twin/robot/robot.h"

// The sanitizer's functions, whose own names are reserved.
void EnterRealtime() __asm__("__rtsan_realtime_enter");
void LeaveRealtime() __asm__("__rtsan_realtime_exit");

namespace twin::loop::rtsan_test {
namespace {

/// While it lives, the thread is in real time.
struct RealtimeSection {
  RealtimeSection() { EnterRealtime(); }
  ~RealtimeSection() { LeaveRealtime(); }
};

constexpr MotionModes kPosition{ControllerMode::kJointImpedance,
                                MotionGeneratorMode::kJointPosition};

/// Gives a state of a running motion at each read.
class Endless final : public backend::Backend {
 public:
  backend::Description Describe() const override { return {}; }
  void Configure(const Setting&) override {}
  void Start(const MotionModes&) override {}
  backend::ReadResult Read(backend::ReadRule, RobotState& state, Time& arrival) noexcept override {
    state.message_id = ++id_;
    state.robot_mode = RobotMode::kMove;
    state.controller_mode = kPosition.controller;
    state.motion_generator_mode = kPosition.generator;
    state.q_d = last_.q_c;
    arrival = Time(kCycle * static_cast<std::int64_t>(id_));
    return backend::ReadResult::kState;
  }
  void Write(const RobotCommand& command) noexcept override { last_ = command; }
  void Stop() override {}
  void Recover() override {}

 private:
  std::uint64_t id_ = 0;
  RobotCommand last_;
};

TEST(RtsanDeathTest, ASectionThatAllocatesEndsTheProgram) {
  EXPECT_DEATH(
      {
        const RealtimeSection section;
        std::vector<int> grows(1000);
        grows.resize(100000);
      },
      "unsafe function");
}

TEST(RtsanTest, TenThousandTicksOfCommunicationAndController) {
  Exchange exchange;
  ControlTick tick({}, control::CommandInterface::kJointPosition, exchange);
  Endless backend;
  AsynchronousLoop loop(tick, backend, {}, 1, nullptr);
  test::Swing swing;
  ControllerLoop controller({}, swing, exchange, 1);
  loop.Activate(kPosition);
  swing.Activate({}, {});
  Time wake = controller.Start(Time(kCycle));
  {
    const RealtimeSection section;
    for (int i = 1; i <= 10000; ++i) {
      static_cast<void>(loop.OnState());
      loop.Write();
      static_cast<void>(loop.OnDone(Time(kCycle * i)));
      if (controller.OnWake(wake)) wake = controller.OnDone(wake);
    }
  }
  EXPECT_GT(loop.timings().written, 9000u);
}

TEST(RtsanTest, TenThousandCyclesOfTheRobot) {
  class Silent final : public rt::EventHandler {
   public:
    void OnEvent(Time, std::uint64_t) noexcept override {}
  };
  rt::EventQueue events;
  Silent silent;
  const robot::RobotConfig config = test::IdealPanda();
  robot::Robot robot(config, std::make_unique<plant::IdealPlant>(), events, silent, nullptr);
  ASSERT_EQ(robot.Move(kPosition), MoveStatus::kMotionStarted);
  robot.Begin();
  RobotCommand command;
  {
    const RealtimeSection section;
    while (events.Now() < Time(std::chrono::seconds(10)) && events.RunNext()) {
      if (!robot.states().has_new()) continue;
      const RobotState& state = robot.states().Take();
      command.message_id = state.message_id;
      command.q_c = state.q_d;
      robot.Send(command);
    }
  }
  EXPECT_EQ(robot.mode(), RobotMode::kMove);
  EXPECT_GE(events.Now(), Time(std::chrono::seconds(10)));
}

/// Every controller with every generator: commands, then more losses than INT takes, error,
/// recovery, and the next motion.
TEST(RtsanTest, EveryModeOfTheRobotWithErrorsAndRecoveries) {
  class Silent final : public rt::EventHandler {
   public:
    void OnEvent(Time, std::uint64_t) noexcept override {}
  };
  using enum ControllerMode;
  using enum MotionGeneratorMode;
  for (const ControllerMode controller :
       {kJointImpedance, kCartesianImpedance, kExternalController}) {
    for (const MotionGeneratorMode generator :
         {kJointPosition, kJointVelocity, kCartesianPosition, kCartesianVelocity}) {
      SCOPED_TRACE(std::string(Name(controller)) + " " + std::string(Name(generator)));
      const MotionModes modes{controller, generator};
      rt::EventQueue events;
      Silent silent;
      const robot::RobotConfig config = test::IdealPanda();
      robot::Robot robot(config, std::make_unique<plant::IdealPlant>(), events, silent, nullptr);
      ASSERT_EQ(robot.Move(modes), MoveStatus::kMotionStarted);
      robot.Begin();
      RobotCommand command;
      int reflexes = 0;
      int motions = 1;
      {
        const RealtimeSection section;
        while (events.Now() < Time(std::chrono::seconds(1)) && events.RunNext()) {
          if (!robot.states().has_new()) continue;
          const RobotState& state = robot.states().Take();
          if (robot.mode() == RobotMode::kReflex) {
            ++reflexes;
            static_cast<void>(robot.AutomaticErrorRecovery());
          } else if (robot.mode() == RobotMode::kIdle) {
            motions += robot.Move(modes) == MoveStatus::kMotionStarted ? 1 : 0;
          }
          if (state.message_id % 200 >= 170) continue;
          command.message_id = state.message_id;
          command.q_c = state.q_d;
          command.O_T_EE_c = state.O_T_EE_d;
          robot.Send(command);
        }
      }
      EXPECT_GT(reflexes, 1);
      EXPECT_GT(motions, 2);
    }
  }
}

}  // namespace
}  // namespace twin::loop::rtsan_test
