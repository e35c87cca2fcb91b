// The communication's ticks and the robot's cycles under RealtimeSanitizer: a call that allocates,
// locks, sleeps or does input and output ends the program.
#include <cmath>
#include <cstddef>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "loop/loop_fixture.h"
#include "support/panda_limits.h"
#include "twin/loop/asynchronous_loop.h"
#include "twin/loop/controller_loop.h"
#include "twin/model/arm_model.h"
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

constexpr JointVector kReady{0, -0.785, 0, -2.356, 0, 1.571, 0.785};
constexpr MotionModes kPosition{ControllerMode::kJointImpedance,
                                MotionGeneratorMode::kJointPosition};

MotionModes ModesOf(control::CommandInterface interface) {
  switch (interface) {
    case control::CommandInterface::kJointPosition: return kPosition;
    case control::CommandInterface::kJointVelocity:
      return {ControllerMode::kJointImpedance, MotionGeneratorMode::kJointVelocity};
    case control::CommandInterface::kCartesianPose:
      return {ControllerMode::kJointImpedance, MotionGeneratorMode::kCartesianPosition};
    case control::CommandInterface::kTorque: break;
  }
  return {ControllerMode::kExternalController, MotionGeneratorMode::kJointVelocity};
}

/// Gives a state of a running motion at each read, whose reference is what was commanded.
class Endless final : public backend::Backend {
 public:
  explicit Endless(control::CommandInterface interface) : interface_(interface) {
    state_.robot_mode = RobotMode::kMove;
    state_.controller_mode = ModesOf(interface).controller;
    state_.motion_generator_mode = ModesOf(interface).generator;
    state_.q = state_.q_d = kReady;
    state_.O_T_EE = state_.O_T_EE_d = state_.O_T_EE_c =
        model::ArmModel::Panda().Pose(model::Frame::kEndEffector, model::Configuration(kReady));
  }
  backend::Description Describe() const override { return {}; }
  void Configure(const Setting&) override {}
  void Start(const MotionModes&) override {}
  backend::ReadResult Read(backend::ReadRule, RobotState& state, Time& arrival) noexcept override {
    ++state_.message_id;
    state = state_;
    arrival = Time(kCycle * static_cast<std::int64_t>(state_.message_id));
    return backend::ReadResult::kState;
  }
  void Write(const RobotCommand& command) noexcept override {
    const RobotState before = state_;
    if (interface_ == control::CommandInterface::kCartesianPose) {
      state_.O_T_EE_d = state_.O_T_EE_c = command.O_T_EE_c;
    }
    for (std::size_t i = 0; i < kJoints; ++i) {
      if (interface_ == control::CommandInterface::kJointPosition) {
        state_.dq_d[i] = (command.q_c[i] - before.q_d[i]) / kT;
      }
      if (interface_ == control::CommandInterface::kJointVelocity) state_.dq_d[i] = command.dq_c[i];
      state_.q_d[i] = before.q_d[i] + state_.dq_d[i] * kT;
      state_.ddq_d[i] = (state_.dq_d[i] - before.dq_d[i]) / kT;
    }
    state_.q = state_.q_d;
  }
  void Stop() override {}
  void Recover() override {}

 private:
  const control::CommandInterface interface_;
  RobotState state_;
};

/// Swings joint 7, or the end effector along z, or gives no torque.
class Swinging final : public control::Controller {
 public:
  explicit Swinging(control::CommandInterface interface) : interface_(interface) {}
  control::CommandInterface command_interface() const noexcept override { return interface_; }
  void Activate(const RobotState& state, Time) override { start_ = state; }
  void Update(const RobotState&, Time now, control::ControllerOutput& output) noexcept override {
    const double swing = 1 - std::cos(ToSeconds(now.time_since_epoch()));
    output.target.joint.q = start_.q_d;
    output.target.joint.q[6] += 0.2 * swing;
    output.target.pose.O_T_EE = start_.O_T_EE_d;
    output.target.pose.O_T_EE[14] += 0.02 * swing;
  }
  void Deactivate() noexcept override {}

 private:
  const control::CommandInterface interface_;
  RobotState start_;
};

/// Chains with every stage that a scenario can have.
std::vector<std::pair<control::CommandInterface, TickConfig>> Chains() {
  using enum control::CommandInterface;
  const model::LabLimits lab{.v_max = 1.5};
  TickConfig whole;
  whole.generator = Generator::kRejoining;
  whole.limits = test::PandaLimits();
  whole.cartesian = test::PandaCartesianLimits();
  whole.viability = 5;
  TickConfig raw = whole;
  raw.generator = Generator::kNone;
  raw.low_pass_hz = 100;
  raw.limiter = reference::ClientLimits::Of(whole.limits, whole.cartesian);
  TickConfig guarded = whole;
  guarded.lab = lab;
  TickConfig cartesian = whole;
  cartesian.generator = Generator::kCartesian;
  TickConfig torque = raw;
  torque.viability.reset();
  return {{kJointPosition, {}},      {kJointPosition, whole},     {kJointPosition, raw},
          {kJointPosition, guarded}, {kJointVelocity, whole},     {kJointVelocity, raw},
          {kJointVelocity, guarded}, {kCartesianPose, whole},     {kCartesianPose, raw},
          {kCartesianPose, guarded}, {kCartesianPose, cartesian}, {kTorque, torque}};
}

TEST(RtsanDeathTest, ASectionThatAllocatesEndsTheProgram) {
  EXPECT_DEATH(
      {
        const RealtimeSection section;
        std::vector<int> grows(1000);
        grows.resize(100000);
      },
      "unsafe function");
}

TEST(RtsanTest, TicksOfCommunicationAndControllerThroughEveryChain) {
  for (const auto& [interface, config] : Chains()) {
    SCOPED_TRACE(static_cast<int>(interface));
    SCOPED_TRACE(static_cast<int>(config.generator));
    Exchange exchange;
    ControlTick tick(config, interface, exchange);
    Endless backend(interface);
    AsynchronousLoop loop(tick, backend, {}, 1, nullptr);
    Swinging swing(interface);
    ControllerLoop controller({}, swing, exchange, 1);
    loop.Activate(ModesOf(interface));
    RobotState start;
    Time arrival;
    backend.Read(backend::ReadRule::kFresh, start, arrival);
    swing.Activate(start, {});
    Time wake = controller.Start(Time(kCycle));
    {
      const RealtimeSection section;
      for (int i = 1; i <= 3000; ++i) {
        static_cast<void>(loop.OnState());
        loop.Write();
        static_cast<void>(loop.OnDone(Time(kCycle * i)));
        if (controller.OnWake(wake)) wake = controller.OnDone(wake);
      }
    }
    EXPECT_GT(loop.timings().written, 2900U);
  }
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
