#include "run/start_check.h"

#include <chrono>
#include <cmath>
#include <deque>
#include <filesystem>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "twin/core/error.h"
#include "twin/model/arm_model.h"
#include "twin/reference/trajectory.h"
#include "twin/rt/signal.h"

namespace twin::run::run_start_check_test {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr JointVector kReady{0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854};
constexpr backend::RobotTime kWall = backend::RobotTime::kWall;
constexpr backend::RobotTime kStates = backend::RobotTime::kStates;

scenario::RobotData Panda() {
  return scenario::LoadRobotData(std::filesystem::path(TWIN_SOURCE_DIR) / "models", "panda",
                                 plant::HandKind::kFrankaHand);
}

/// A robot that is ready.
RobotState Ready() {
  RobotState state;
  state.robot_mode = RobotMode::kIdle;
  state.q = state.q_d = kReady;
  state.m_ee = 0.73;
  return state;
}

/// What is heard from a robot that is well: all states, each on its millisecond.
loop::ListenReport Heard() {
  loop::ListenReport heard;
  heard.states = 500;
  heard.in_time = 499;
  heard.rate_hz = 1000;
  for (int i = 0; i < 499; ++i) heard.deviation.Add(microseconds(20));
  heard.last = Ready();
  return heard;
}

TEST(StartCheckTest, ARobotThatIsReadyPassesAllChecks) {
  const scenario::RobotData robot = Panda();
  const scenario::Scenario scenario;
  const RobotState state = Ready();
  EXPECT_TRUE(CheckStates(Heard(), kWall).ok);
  EXPECT_TRUE(CheckMode(state).ok);
  EXPECT_TRUE(CheckErrors(state).ok);
  EXPECT_TRUE(CheckLimits(state, robot.limits).ok);
  EXPECT_TRUE(CheckPayload(state, scenario, robot).ok);
  EXPECT_TRUE(CheckStart(state, scenario, kReady).ok);
  EXPECT_TRUE(CheckCommunication(Heard(), {}, kWall).ok);
  EXPECT_TRUE(CheckScheduler({}, kWall).ok);
}

TEST(StartCheckTest, StatesMustComeAtTheRobotsRate) {
  EXPECT_THAT(CheckStates({}, kWall).text, HasSubstr("firewall"));
  loop::ListenReport slow = Heard();
  slow.rate_hz = 900;
  EXPECT_FALSE(CheckStates(slow, kWall).ok);
  EXPECT_THAT(CheckStates(slow, kWall).text, AllOf(HasSubstr("900"), HasSubstr("states")));
  slow.rate_hz = 100;
  EXPECT_TRUE(CheckStates(slow, kStates).ok) << "its host may be slow: the states are the time";
}

TEST(StartCheckTest, EveryModeButIdleIsRefusedWithItsWayOut) {
  RobotState state = Ready();
  for (const auto& [mode, way] : {std::pair{RobotMode::kOther, "brakes"},
                                  {RobotMode::kMove, "another program"},
                                  {RobotMode::kGuiding, "guiding button"},
                                  {RobotMode::kReflex, "recover"},
                                  {RobotMode::kUserStopped, "release the user stop"},
                                  {RobotMode::kAutomaticErrorRecovery, "wait"}}) {
    state.robot_mode = mode;
    EXPECT_FALSE(CheckMode(state).ok);
    EXPECT_THAT(CheckMode(state).text, HasSubstr(way));
  }
}

TEST(StartCheckTest, CurrentErrorsAreNamed) {
  RobotState state = Ready();
  state.errors.set(static_cast<std::size_t>(RobotError::kJointReflex));
  EXPECT_FALSE(CheckErrors(state).ok);
  EXPECT_THAT(CheckErrors(state).text, HasSubstr("joint_reflex"));
}

TEST(StartCheckTest, AJointNearItsLimitIsNamed) {
  const scenario::RobotData robot = Panda();
  for (std::size_t i = 0; i < kJoints; ++i) {
    for (const double inside : {0.019, 0.021}) {
      RobotState low = Ready();
      low.q[i] = robot.limits.q_min[i] + inside;
      RobotState high = Ready();
      high.q[i] = robot.limits.q_max[i] - inside;
      EXPECT_EQ(CheckLimits(low, robot.limits).ok, inside > 0.02) << i;
      EXPECT_EQ(CheckLimits(high, robot.limits).ok, inside > 0.02) << i;
    }
    RobotState none = Ready();
    none.q[i] = std::nan("");
    EXPECT_FALSE(CheckLimits(none, robot.limits).ok) << i;
  }
  RobotState state = Ready();
  state.q[3] = robot.limits.q_max[3];
  EXPECT_THAT(CheckLimits(state, robot.limits).text, HasSubstr("joint 4"));
}

TEST(StartCheckTest, ThePayloadMustBeWhatTheScenarioSays) {
  const scenario::RobotData robot = Panda();
  scenario::Scenario scenario;
  RobotState state = Ready();
  state.m_ee = 0;
  EXPECT_THAT(CheckPayload(state, scenario, robot).text,
              AllOf(HasSubstr("0.000 kg"), HasSubstr("0.730 kg"), HasSubstr("Desk")));
  state = Ready();
  scenario.onboard.load.m_load = 0.5;
  EXPECT_FALSE(CheckPayload(state, scenario, robot).ok);
  state.m_load = 0.5;
  EXPECT_TRUE(CheckPayload(state, scenario, robot).ok);
  state.F_x_Cload[1] = 0.01;
  EXPECT_FALSE(CheckPayload(state, scenario, robot).ok);
}

/// @returns a robot at rest that carries a load, its base tilted.
RobotState Holding(double m_load, double roll, double pitch) {
  constexpr double kG = 9.81;
  RobotState state = Ready();
  const model::Payload all =
      model::Combine(Panda().end_effector, {.m = m_load, .F_x_C = {0, 0, 0.1}, .I = {}});
  state.tau_J = model::ArmModel::Panda().Gravity(
      state.q, all,
      {kG * std::sin(pitch), -kG * std::cos(pitch) * std::sin(roll),
       -kG * std::cos(pitch) * std::cos(roll)});
  return state;
}

TEST(StartCheckTest, TorquesAtRestAreThoseOfTheTiltAndLoadThatAreSaid) {
  const scenario::RobotData robot = Panda();
  scenario::Scenario scenario;
  EXPECT_TRUE(CheckTorques(Holding(0, 0, 0), scenario, robot).ok);
  EXPECT_FALSE(CheckTorques(Holding(0.5, 0, 0), scenario, robot).ok);
  scenario.robot.load = {.m_load = 0.5, .F_x_Cload = {0, 0, 0.1}, .I_load = {}};
  EXPECT_TRUE(CheckTorques(Holding(0.5, 0, 0), scenario, robot).ok);
  scenario.robot.load = {};
  const RobotState tilted = Holding(0, 0.1, -0.08);
  const CheckLine line = CheckTorques(tilted, scenario, robot);
  EXPECT_FALSE(line.ok);
  EXPECT_THAT(line.text, AllOf(HasSubstr("tilted by 0.0, 0.0 deg"), HasSubstr("load of 0.000 kg"),
                               HasSubstr("plant.base_tilt")));
  scenario.plant.base_tilt = {.roll = 0.1, .pitch = -0.08};
  EXPECT_TRUE(CheckTorques(tilted, scenario, robot).ok)
      << CheckTorques(tilted, scenario, robot).text;
}

TEST(StartCheckTest, HeavierLinksHoldMore) {
  const scenario::RobotData robot = Panda();
  scenario::Scenario scenario;
  RobotState state = Holding(0, 0, 0);
  for (double& tau : state.tau_J) tau *= 1.1;
  EXPECT_FALSE(CheckTorques(state, scenario, robot).ok);
  scenario.plant.mass_scale = 1.1;
  EXPECT_TRUE(CheckTorques(state, scenario, robot).ok);
}

TEST(StartCheckTest, ARobotWithoutTorqueSensorsIsNotJudgedByThem) {
  EXPECT_TRUE(CheckTorques(Ready(), scenario::Scenario(), Panda()).ok);
  RobotState state = Holding(0, 0, 0);
  state.tau_J[3] = std::nan("");
  EXPECT_FALSE(CheckTorques(state, scenario::Scenario(), Panda()).ok);
}

TEST(StartCheckTest, TheJointFarthestFromTheStartIsNamed) {
  RobotState state = Ready();
  state.q_d[1] += 0.01;
  state.q_d[3] += 0.2;
  const CheckLine line = CheckStart(state, scenario::Scenario(), kReady);
  EXPECT_FALSE(line.ok);
  EXPECT_THAT(line.text, AllOf(HasSubstr("joint 4"), HasSubstr("0.2000 rad")));
}

TEST(StartCheckTest, OfAPlannedMotionItTellsHowNearTheArmMustStand) {
  scenario::Scenario scenario;
  scenario.motion.plan.emplace();
  RobotState state = Ready();
  state.q_d[3] += 0.03;
  const CheckLine line = CheckStart(state, scenario, kReady);
  EXPECT_FALSE(line.ok);
  EXPECT_THAT(line.text, AllOf(HasSubstr("0.0300 rad from the plan's start"),
                               HasSubstr("within 0.02 rad of robot.q_start")));
}

TEST(StartCheckTest, AReferenceThatIsNoNumberIsNotTheStart) {
  RobotState state = Ready();
  state.q_d[5] = std::nan("");
  EXPECT_THAT(CheckStart(state, scenario::Scenario(), kReady).text, HasSubstr("joint 6"));
}

TEST(StartCheckTest, TorquesStartFromTheMeasuredArm) {
  scenario::Scenario scenario;
  scenario.motion.interface = control::CommandInterface::kTorque;
  RobotState state = Ready();
  state.q_d[1] += 1;
  state.q[1] += 0.015;
  EXPECT_TRUE(CheckStart(state, scenario, kReady).ok);
  state.q[1] += 0.01;
  EXPECT_FALSE(CheckStart(state, scenario, kReady).ok);
}

TEST(StartCheckTest, TooFewStatesInTimeAreRefusedOnTheWallClock) {
  loop::ListenReport heard = Heard();
  heard.in_time = 440;
  EXPECT_FALSE(CheckCommunication(heard, {}, kWall).ok);
  EXPECT_THAT(CheckCommunication(heard, {}, kWall).text, HasSubstr("0.882"));
  EXPECT_TRUE(CheckCommunication(heard, {}, kStates).ok);
}

TEST(StartCheckTest, RightsThatLackAreRefusedOnTheWallClock) {
  EXPECT_THAT(CheckScheduler({"no FIFO", "no lock"}, kWall).text, HasSubstr("no FIFO; no lock"));
  EXPECT_FALSE(CheckScheduler({"no FIFO"}, kWall).ok);
  EXPECT_TRUE(CheckScheduler({"no FIFO"}, kStates).ok);
}

TEST(StartCheckTest, SendsEverySettingOfTheSectionInt) {
  scenario::OnboardSection onboard;
  onboard.K_theta[2] = 1234;
  onboard.load.m_load = 0.7;
  const std::vector<Setting> settings = SettingsOf(onboard, true);
  ASSERT_EQ(settings.size(), std::variant_size_v<Setting>);
  std::vector<bool> sent(settings.size());
  for (const Setting& setting : settings) {
    sent[setting.index()] = true;
    EXPECT_FALSE(FindBadValue(setting)) << twin::Name(setting);
  }
  EXPECT_THAT(sent, ::testing::Each(true));
  EXPECT_EQ(std::get<setting::JointImpedance>(settings[0]).K_theta[2], 1234);
}

/// A robot that gives a state whenever it is asked, and takes settings unless told not to.
class Robot final : public backend::Backend, public rt::Arrival {
 public:
  explicit Robot(const MonotonicClock& clock) : clock_(clock) {}

  [[nodiscard]] backend::Description Describe() const override { return {}; }
  void Configure(const Setting& setting) override {
    if (refuses) throw RobotFault("Set Load rejected");
    ++settings;
    if (const auto* load = std::get_if<setting::Load>(&setting)) state.m_load = load->m_load;
  }
  void Start(const MotionModes&) override { ++motions; }
  backend::ReadResult Read(backend::ReadRule, RobotState& read, Time& at) noexcept override {
    ++state.message_id;
    read = state;
    at = clock_.Now();
    return backend::ReadResult::kState;
  }
  void Write(const RobotCommand&) noexcept override { ++motions; }
  void Stop() override {}
  void Recover() override {}
  bool AwaitUntil(Time) noexcept override { return true; }

  RobotState state = Ready();
  bool refuses = false;
  int settings = 0;
  int motions = 0;

 private:
  const MonotonicClock& clock_;
};

class RunStartCheckTest : public ::testing::Test {
 protected:
  bool Run() {
    StartCheck check{
        .clock = clock_, .backend = robot_, .arrival = robot_, .time = kStates, .listening = {}};
    check.listening.span = milliseconds(5);
    check.listening.thread.lock_memory = false;
    lines_.clear();
    return RunStartCheck(check, scenario_, Panda(), kReady, [this](const CheckLine& line) {
      lines_.emplace_back(std::string(line.subject) + (line.ok ? "" : " FAILED"));
    });
  }
  MonotonicClock clock_;
  Robot robot_{clock_};
  scenario::Scenario scenario_;
  std::vector<std::string> lines_;
};

// This robot counts states as fast as it is asked for them: their rate is never 1000 Hz.
TEST_F(RunStartCheckTest, TellsEveryLineAndNeverMovesTheArm) {
  scenario_.onboard.load.m_load = 0.5;
  static_cast<void>(Run());
  EXPECT_THAT(lines_, ElementsAre(HasSubstr("states"), "mode", "errors", "joint limits", "settings",
                                  "payload", "torques", "start", "communication", "scheduler"));
  EXPECT_EQ(robot_.settings, 8);
  EXPECT_EQ(robot_.motions, 0);
}

TEST_F(RunStartCheckTest, SendsNoSettingsToARobotThatIsNotIdle) {
  robot_.state.robot_mode = RobotMode::kUserStopped;
  EXPECT_FALSE(Run());
  EXPECT_THAT(lines_, ElementsAre(HasSubstr("states"), "mode FAILED", "errors", "joint limits",
                                  "torques", "start", "communication", "scheduler"));
  EXPECT_EQ(robot_.settings, 0);
}

TEST_F(RunStartCheckTest, GoesOnAfterSettingsThatWereRefused) {
  robot_.refuses = true;
  EXPECT_FALSE(Run());
  EXPECT_THAT(lines_,
              ElementsAre(HasSubstr("states"), "mode", "errors", "joint limits", "settings FAILED",
                          "torques", "start", "communication", "scheduler"));
}

}  // namespace
}  // namespace twin::run::run_start_check_test
