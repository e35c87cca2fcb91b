#include <chrono>
#include <cmath>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include "controllers/joint_trajectory.h"
#include "plugins/backends.h"
#include "twin/core/error.h"
#include "twin/model/arm_model.h"
#include "twin/plant/truth_probe.h"
#include "twin/run/run.h"

namespace twin::run::run_interaction_test {
namespace {

using namespace std::chrono_literals;  // NOLINT(google-build-using-namespace): 300ms

/// Keeps all states of a run.
class States final : public record::RecordSink {
 public:
  void Put(const record::CycleRecord& record) noexcept override { states.push_back(record.state); }
  void Put(const record::TickRecord& /*record*/) noexcept override {}

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

  [[nodiscard]] scenario::Scenario Example(const char* name) const {
    return scenario::Load(files_.models / "scenarios" / (std::string(name) + ".yaml"));
  }

  RunResult Execute(const scenario::Scenario& scenario) {
    run::Run run(scenario, {backends_, controllers_}, files_, &states_);
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
  scenario::Scenario scenario = Example("collision");
  scenario.onboard.collision_behavior = scenario::NoCollisionBehavior();
  const RunResult result = Execute(scenario);
  EXPECT_TRUE(result.report.succeeded()) << result.report.failure;
}

// Somebody leads the hand of an arm that is soft: it follows, by the springs in series.
TEST_F(InteractionTest, AHandLeadsASoftArm) {
  scenario::Scenario scenario = Example("push");
  scenario.onboard.collision_behavior = scenario::NoCollisionBehavior();
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

/// Between the origins of two poses, m.
double Distance(const Transform& a, const Transform& b) {
  return std::hypot(a[12] - b[12], a[13] - b[13], a[14] - b[14]);
}

/// The angle of the turn between two poses, by the chords their axes make: rad.
double Turn(const Transform& a, const Transform& b) {
  double squares = 0;
  for (const std::size_t axis : {0, 4, 8}) {
    for (std::size_t i = axis; i < axis + 3; ++i) squares += (a[i] - b[i]) * (a[i] - b[i]);
  }
  return 2 * std::asin(std::sqrt(squares / 8));
}

TEST_F(InteractionTest, PosesLeadTheHandToTheGoal) {
  const scenario::Scenario scenario = Example("cartesian");
  const RunResult result = Execute(scenario);
  EXPECT_TRUE(result.report.succeeded()) << result.report.failure;
  const RobotState& last = states_.states.back();
  const Transform goal =
      model::ArmModel::Panda().Pose(model::Frame::kEndEffector, result.goal, last.F_T_EE);
  for (std::size_t i = 0; i < goal.size(); ++i) EXPECT_NEAR(last.O_T_EE_d[i], goal[i], 2e-4) << i;
  for (std::size_t i = 12; i < 15; ++i) EXPECT_NEAR(last.O_T_EE[i], goal[i], 2e-3) << i;
  ASSERT_TRUE(result.final_pose_error);
  // The last state is a cycle younger, and the soft arm still settles, at some mrad/s.
  EXPECT_NEAR(result.final_pose_error->distance, Distance(last.O_T_EE, goal), 1e-5);
  EXPECT_NEAR(result.final_pose_error->angle, Turn(last.O_T_EE, goal), 1e-5);
  EXPECT_EQ(states_.At(2s).motion_generator_mode, MotionGeneratorMode::kCartesianPosition);
  EXPECT_EQ(states_.At(2s).controller_mode, ControllerMode::kCartesianImpedance);
}

/// The fastest joint, rad/s.
double Speed(const RobotState& state) {
  double fastest = 0;
  for (const double dq : state.dq) fastest = std::max(fastest, std::abs(dq));
  return fastest;
}

// Without the rotors' inertia, which INT's damping reckons with, so stiff an arm swings for ever.
TEST_F(InteractionTest, AnArmThatSwingsAfterItsMotionIsBrakedAndNoSuccess) {
  scenario::Scenario scenario = Example("push");
  scenario.perturbations.clear();
  scenario.plant.armature = false;
  scenario.onboard.K_theta.fill(14250);
  scenario.onboard.collision_behavior = scenario::NoCollisionBehavior();
  const RunResult result = Execute(scenario);
  EXPECT_EQ(result.report.end, backend::MotionEnd::kSuccess);
  EXPECT_FALSE(result.report.succeeded());
  EXPECT_NE(result.report.failure.find("did not come to rest"), std::string::npos)
      << result.report.failure;
  EXPECT_NE(result.report.failure.find("instability_detected"), std::string::npos)
      << result.report.failure;
  std::size_t end = states_.states.size() - 1;
  while (states_.states[end].robot_mode != RobotMode::kMove) --end;
  EXPECT_GT(Speed(states_.states[end]), 0.05);
  ASSERT_GT(states_.states.size(), end + 1001);
  EXPECT_EQ(states_.states[end + 1001].robot_mode, RobotMode::kReflex);
  EXPECT_LT(Speed(states_.states.back()), 0.05);
}

TEST_F(InteractionTest, AnArmThatRestsEndsItsRunAsSoonAsBefore) {
  const RunResult result = Execute(Example("push"));
  ASSERT_TRUE(result.report.succeeded()) << result.report.failure;
  std::size_t end = states_.states.size() - 1;
  while (states_.states[end].robot_mode != RobotMode::kMove) --end;
  EXPECT_LE(states_.states.size() - end, 22U);
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
  scenario::Scenario scenario = Example("user_stop");
  scenario.panel.at(0).at = 1us;
  const RunResult result = Execute(scenario);
  EXPECT_EQ(result.report.end, backend::MotionEnd::kUserStopped);
  EXPECT_EQ(result.report.failure, "motion aborted: user stop pressed");
  EXPECT_LT(result.report.simulated, 2s);
}

TEST_F(InteractionTest, ARobotThatFiltersItsCommandsIsFollowed) {
  scenario::Scenario scenario = Example("smoke");
  scenario.tick.generator = loop::Generator::kNone;
  scenario.onboard.filters.joint_position_hz = 100;
  const RunResult result = Execute(scenario);
  EXPECT_EQ(result.report.end, backend::MotionEnd::kSuccess);
  EXPECT_LT(result.report.simulated, 10s);
}

TEST_F(InteractionTest, TheIdealPlantCarriesTheLoadToo) {
  scenario::Scenario scenario = Example("smoke");
  scenario.robot.load = {.m_load = 1, .F_x_Cload = {0, 0, 0.1}};
  EXPECT_TRUE(Execute(scenario).report.succeeded());
  EXPECT_NEAR(states_.states.back().O_F_ext_hat_K[2], 9.81, 0.2) << "INT is not told of it";
  states_.states.clear();
  scenario.onboard.load = scenario.robot.load;
  EXPECT_TRUE(Execute(scenario).report.succeeded());
  EXPECT_NEAR(states_.states.back().O_F_ext_hat_K[2], 0, 0.2);
}

/// Height of a body's centre in the world at the end of a run, m.
double HeightOf(const plant::TruthProbe& truth, const char* body) {
  const int id = mj_name2id(&truth.model(), mjOBJ_BODY, body);
  EXPECT_GE(id, 0) << body;
  return truth.data().xpos[3 * id + 2];
}

TEST_F(InteractionTest, TheHandTakesTheBoxAndTheArmLiftsIt) {
  const scenario::Scenario scenario = Example("grasp");
  run::Run run(scenario, {backends_, controllers_}, files_, &states_);
  std::vector<std::string> events;
  RunHooks hooks;
  hooks.event = [&events](Time, std::string_view kind, std::string_view text) {
    if (kind == "hand") events.emplace_back(text);
  };
  EXPECT_NEAR(HeightOf(*run.connection().truth, "box"), 0.325, 1e-3);
  const RunResult result = run.Execute(hooks);
  EXPECT_TRUE(result.report.succeeded()) << result.report.failure;
  EXPECT_NEAR(HeightOf(*run.connection().truth, "box"), 0.475, 5e-3);
  ASSERT_TRUE(result.hand);
  EXPECT_TRUE(result.hand->state.is_grasped);
  EXPECT_NEAR(result.hand->state.width, 0.05, 5e-4);
  ASSERT_EQ(result.hand->commands.size(), 2u);
  for (const HandOutcome& command : result.hand->commands) {
    EXPECT_EQ(command.result, HandResult::kSuccess);
  }
  EXPECT_TRUE(result.hand->commands[1].is_grasped);
  EXPECT_EQ(events.size(), 4u) << "a begin and an end of each";
}

TEST_F(InteractionTest, AHandThatClosesTooEarlyGraspsNothingAndStrikesTheBox) {
  scenario::Scenario scenario = Example("grasp");
  scenario.hand[1].at = 200ms;
  const RunResult result = Execute(scenario);
  ASSERT_TRUE(result.hand);
  EXPECT_EQ(result.hand->commands[1].result, HandResult::kUnsuccessful);
  EXPECT_FALSE(result.hand->state.is_grasped);
  EXPECT_EQ(result.report.end, backend::MotionEnd::kAborted);
  EXPECT_TRUE(result.report.errors.test(static_cast<std::size_t>(RobotError::kCartesianReflex)));
}

TEST_F(InteractionTest, TheHandDoesTheSameInEveryRun) {
  const scenario::Scenario scenario = Example("grasp");
  const RunResult first = Execute(scenario);
  const RunResult second = Execute(scenario);
  EXPECT_EQ(second.states_hash, first.states_hash);
  for (std::size_t i = 0; i < scenario.hand.size(); ++i) {
    EXPECT_EQ(second.hand->commands[i].begun, first.hand->commands[i].begun);
    EXPECT_EQ(second.hand->commands[i].ended, first.hand->commands[i].ended);
  }
  EXPECT_EQ(second.hand->state, first.hand->state);
  scenario::Scenario other = scenario;
  other.hand[1].at += 1ms;
  EXPECT_NE(Execute(other).states_hash, first.states_hash);
}

TEST_F(InteractionTest, WithoutCommandsNothingIsToldOfTheHandNorOfPoses) {
  const RunResult result = Execute(Example("smoke"));
  EXPECT_FALSE(result.hand);
  EXPECT_FALSE(result.final_pose_error);
}

TEST_F(InteractionTest, PushesAreTheSameInEveryRun) {
  const scenario::Scenario scenario = Example("push");
  const std::uint64_t first = Execute(scenario).states_hash;
  EXPECT_EQ(Execute(scenario).states_hash, first);
  scenario::Scenario other = scenario;
  std::get<plant::Push>(other.perturbations[0]).force[1] = 30.001;
  EXPECT_NE(Execute(other).states_hash, first);
}

TEST_F(InteractionTest, AWrongBodyIsAnsweredWithTheNamesOfAll) {
  scenario::Scenario scenario = Example("push");
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
}  // namespace twin::run::run_interaction_test
