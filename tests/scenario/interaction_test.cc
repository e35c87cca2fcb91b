#include <chrono>
#include <cmath>
#include <filesystem>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "controllers/joint_trajectory.h"
#include "plugins/mujoco/mujoco_backend.h"
#include "twin/core/error.h"
#include "twin/model/arm_model.h"
#include "twin/scenario/assembly.h"

namespace twin::scenario {
namespace {

using namespace std::chrono_literals;  // NOLINT(google-build-using-namespace): 300ms

/// Keeps all states of a run.
class States final : public rt::RecordSink {
 public:
  void Put(const rt::CycleRecord& record) noexcept override { states.push_back(record.state); }
  void Put(const rt::TickRecord& /*record*/) noexcept override {}

  /// State k is of k ms.
  [[nodiscard]] const RobotState& At(Duration t) const {
    return states.at(static_cast<std::size_t>(t / kCycle) - 1);
  }

  std::vector<RobotState> states;
};

/// The examples of what touches a robot, run as examples are.
class InteractionTest : public ::testing::Test {
 protected:
  InteractionTest() {
    plugins::RegisterMujoco(backends_);
    controllers_.Add("joint_trajectory", [](const control::ControllerRequest& request) {
      controllers::JointTrajectoryOptions options;
      options.command_interface = request.interface;
      return std::make_unique<controllers::JointTrajectoryController>(request.trajectory, options);
    });
  }

  [[nodiscard]] Scenario Example(const char* name) const {
    return Load(files_.models / "scenarios" / (std::string(name) + ".yaml"));
  }

  RunResult Execute(const Scenario& scenario) {
    scenario::Run run(scenario, {backends_, controllers_}, files_, &states_);
    return run.Execute();
  }

  backend::Registry backends_;
  control::ControllerRegistry controllers_;
  const RunFiles files_{std::filesystem::path(TWIN_SOURCE_DIR) / "models", {}, {}, false};
  States states_;
};

TEST_F(InteractionTest, APushBelowTheUpperThresholdsIsAContactAndNoMore) {
  const RunResult result = Execute(Example("push"));
  EXPECT_TRUE(result.report.succeeded()) << result.report.failure;
  const auto touched = [this](Duration t) {
    const RobotState& state = states_.At(t);
    return state.cartesian_contact[1] != 0 || state.cartesian_contact[2] != 0;
  };
  EXPECT_FALSE(touched(950ms));
  EXPECT_TRUE(touched(1400ms));
  EXPECT_TRUE(touched(2900ms));
  EXPECT_FALSE(touched(4s));
  // Told as what the robot does to whoever pushes.
  EXPECT_NEAR(states_.At(1500ms).O_F_ext_hat_K[1], -30, 3);
  EXPECT_NEAR(states_.At(3s).O_F_ext_hat_K[2], 30, 3);
}

TEST_F(InteractionTest, APushAboveTheUpperThresholdsEndsTheMotion) {
  const RunResult result = Execute(Example("collision"));
  EXPECT_EQ(result.report.end, backend::MotionEnd::kAborted);
  EXPECT_TRUE(result.report.errors.test(static_cast<std::size_t>(RobotError::kCartesianReflex)));
  EXPECT_EQ(states_.At(1050ms).robot_mode, RobotMode::kMove);
  EXPECT_EQ(states_.At(1200ms).robot_mode, RobotMode::kReflex);
}

TEST_F(InteractionTest, WithoutThresholdsTheSamePushIsBorne) {
  Scenario scenario = Example("collision");
  scenario.onboard.collision_behavior = NoCollisionBehavior();
  const RunResult result = Execute(scenario);
  EXPECT_TRUE(result.report.succeeded()) << result.report.failure;
}

// Somebody leads the hand of an arm that is soft: it follows, by the springs in series.
TEST_F(InteractionTest, AHandLeadsASoftArm) {
  Scenario scenario = Example("push");
  scenario.onboard.collision_behavior = NoCollisionBehavior();
  scenario.onboard.K_x = {200, 200, 200, 50, 50, 50};
  scenario.motion.controller = ControllerMode::kCartesianImpedance;
  scenario.motion.waypoints.back().q = scenario.motion.waypoints.front().q;
  scenario.motion.waypoints.back().q[6] += 1e-3;  // next to nothing: a motion, but none to see
  // The origin of EE is at z = 0.1034 m of the hand: there a force bends no rotational spring.
  scenario.perturbations = {plant::HandSpring{.body = "panda_hand",
                                              .point = {0, 0, 0.1034},
                                              .begin = 1s,
                                              .duration = 10s,
                                              .from = Vector3{0.3069, 0.2, 0.4866},
                                              .stiffness = 200,
                                              .damping = 20,
                                              .largest_force = 100}};
  const RunResult result = Execute(scenario);
  EXPECT_TRUE(result.report.succeeded()) << result.report.failure;
  EXPECT_NEAR(states_.At(900ms).O_T_EE[13], 0, 0.002);
  EXPECT_NEAR(states_.At(4800ms).O_T_EE[13], 0.1, 0.01) << "half way between two equal springs";
}

TEST_F(InteractionTest, PosesLeadTheHandToTheGoal) {
  const Scenario scenario = Example("cartesian");
  const RunResult result = Execute(scenario);
  EXPECT_TRUE(result.report.succeeded()) << result.report.failure;
  const RobotState& last = states_.states.back();
  const Transform goal =
      model::ArmModel::Panda().Pose(model::Frame::kEndEffector, result.goal, last.F_T_EE);
  for (std::size_t i = 0; i < goal.size(); ++i) EXPECT_NEAR(last.O_T_EE_d[i], goal[i], 2e-4) << i;
  for (std::size_t i = 12; i < 15; ++i) EXPECT_NEAR(last.O_T_EE[i], goal[i], 2e-3) << i;
  EXPECT_EQ(states_.At(2s).motion_generator_mode, MotionGeneratorMode::kCartesianPosition);
  EXPECT_EQ(states_.At(2s).controller_mode, ControllerMode::kCartesianImpedance);
}

TEST_F(InteractionTest, TheUserStopEndsTheMotionAndTheBrakesHold) {
  const RunResult result = Execute(Example("user_stop"));
  EXPECT_EQ(result.report.end, backend::MotionEnd::kUserStopped);
  EXPECT_EQ(states_.At(2990ms).robot_mode, RobotMode::kMove);
  const RobotState& last = states_.states.back();
  EXPECT_EQ(last.robot_mode, RobotMode::kUserStopped);
  for (const double dq : last.dq) EXPECT_LT(std::abs(dq), 1e-6);
  const RobotState& before = states_.states[states_.states.size() - 100];
  for (std::size_t i = 0; i < kJoints; ++i) EXPECT_NEAR(last.q[i], before.q[i], 1e-7);
}

TEST_F(InteractionTest, AUserStopBeforeTheFirstCycleOfTheMotionIsSeen) {
  Scenario scenario = Example("user_stop");
  scenario.panel.at(0).at = 1us;
  const RunResult result = Execute(scenario);
  EXPECT_EQ(result.report.end, backend::MotionEnd::kUserStopped);
  EXPECT_EQ(result.report.failure, "motion aborted: user stop pressed");
  EXPECT_LT(result.report.simulated, 2s);
}

TEST_F(InteractionTest, ARobotThatFiltersItsCommandsIsFollowed) {
  Scenario scenario = Example("smoke");
  scenario.tick.generator = loop::Generator::kNone;
  scenario.onboard.filters.joint_position_hz = 100;
  const RunResult result = Execute(scenario);
  EXPECT_EQ(result.report.end, backend::MotionEnd::kSuccess);
  EXPECT_LT(result.report.simulated, 10s);
}

TEST_F(InteractionTest, TheIdealPlantCarriesTheLoadToo) {
  Scenario scenario = Example("smoke");
  scenario.robot.load = {.m_load = 1, .F_x_Cload = {0, 0, 0.1}};
  EXPECT_TRUE(Execute(scenario).report.succeeded());
  EXPECT_NEAR(states_.states.back().O_F_ext_hat_K[2], 9.81, 0.2) << "INT is not told of it";
  states_.states.clear();
  scenario.onboard.load = scenario.robot.load;
  EXPECT_TRUE(Execute(scenario).report.succeeded());
  EXPECT_NEAR(states_.states.back().O_F_ext_hat_K[2], 0, 0.2);
}

TEST_F(InteractionTest, PushesAreTheSameInEveryRun) {
  const Scenario scenario = Example("push");
  const std::uint64_t first = Execute(scenario).states_hash;
  EXPECT_EQ(Execute(scenario).states_hash, first);
  Scenario other = scenario;
  std::get<plant::Push>(other.perturbations[0]).force[1] = 30.001;
  EXPECT_NE(Execute(other).states_hash, first);
}

TEST_F(InteractionTest, AWrongBodyIsAnsweredWithTheNamesOfAll) {
  Scenario scenario = Example("push");
  std::get<plant::Push>(scenario.perturbations[0]).body = "panda_hnad";
  try {
    (void)Execute(scenario);
    FAIL() << "accepted";
  } catch (const InputError& error) {
    const std::string text = error.what();
    EXPECT_NE(text.find("\"panda_hnad\""), std::string::npos) << text;
    EXPECT_NE(text.find("panda_hand"), std::string::npos) << text;
  }
}

}  // namespace
}  // namespace twin::scenario
