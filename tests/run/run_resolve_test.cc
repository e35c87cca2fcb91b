#include "run/resolve.h"

#include <chrono>
#include <filesystem>
#include <string>
#include <variant>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenario/scenario_examples.h"
#include "twin/core/error.h"
#include "twin/run/run.h"

namespace twin::run::run_resolve_test {
namespace {

using namespace std::chrono_literals;  // NOLINT(google-build-using-namespace): 300us
using ::testing::HasSubstr;
using ::testing::StartsWith;

/// A catalogue of names: nothing is connected or made here.
class PlanTest : public ::testing::Test {
 protected:
  PlanTest() {
    backends_.Add("mujoco", [](const backend::Request&) { return backend::Connection(); });
    for (const char* name : {"joint_trajectory", "joint_trajectory_effort"}) {
      controllers_.Add(name, [](const control::ControllerRequest&) { return nullptr; });
    }
  }

  [[nodiscard]] Plan PlanOf(const scenario::Scenario& scenario) const {
    return MakePlan(scenario, {backends_, controllers_}, files_);
  }
  [[nodiscard]] Plan PlanOf(const std::string& text) const {
    return PlanOf(scenario::Parse(text, "s.yaml"));
  }
  [[nodiscard]] std::string MessageOf(const scenario::Scenario& scenario) const {
    try {
      (void)PlanOf(scenario);
    } catch (const InputError& error) {
      return error.what();
    }
    return "(accepted)";
  }

  backend::Registry backends_;
  control::ControllerRegistry controllers_;
  const RunFiles files_{std::filesystem::path(TWIN_SOURCE_DIR) / "models", {}, {}, false};
};

/// FullText() with a motion that is within the limits and starts where the arm rests.
scenario::Scenario Full() {
  return scenario::Parse(scenario::test::FullText(), "s.yaml");
}

TEST_F(PlanTest, TellsTheRobotAllTheScenarioSays) {
  const scenario::Scenario scenario = Full();
  const Plan plan = PlanOf(scenario);
  const robot::RobotConfig& config = plan.config;
  EXPECT_EQ(config.plant_kind, robot::PlantKind::kIdeal);
  EXPECT_EQ(config.seed, 42u);
  EXPECT_EQ(config.clock_ppm, 5);
  EXPECT_EQ(config.q_start, *scenario.robot.q_start);
  EXPECT_EQ(config.onboard.abort_after_lost, 19u);
  EXPECT_EQ(config.onboard.damping_ratio, 0.7);
  EXPECT_EQ(config.onboard.friction_compensation, 0.8);
  EXPECT_EQ(config.onboard.joint_impedance.K_theta[6], 1999.5);
  EXPECT_EQ(config.onboard.limits.dq_max, plan.robot.limits.dq_max);
  EXPECT_EQ(config.onboard.rotor_inertia, JointVector{}) << "armature is off";
  EXPECT_EQ(config.plant.friction, plant::FrictionProfile::kBreakaway);
  EXPECT_EQ(config.plant.hand, plant::HandKind::kNone);
  EXPECT_EQ(config.plant.scene, files_.models / "scenes/floor.xml");
  EXPECT_EQ(config.plant.noise.tau_J_Nm, 0.3);
  EXPECT_EQ(config.plant.seed, 42u);
}

TEST_F(PlanTest, TellsTheRobotWhatItIsSetToAndWhatTouchesIt) {
  const scenario::Scenario scenario = scenario::Parse(scenario::test::TouchedText(), "s.yaml");
  const robot::RobotConfig config = PlanOf(scenario).config;
  EXPECT_EQ(config.plant.load, scenario.robot.load);
  EXPECT_EQ(config.plant.elasticity, plant::ElasticityProfile::kStatic);
  EXPECT_EQ(config.plant.perturbations, scenario.perturbations);
  EXPECT_EQ(config.panel, scenario.panel);
  const onboard::OnboardConfig& onboard = config.onboard;
  EXPECT_EQ(onboard.load, scenario.onboard.load);
  EXPECT_EQ(onboard.cartesian_impedance.K_x, scenario.onboard.K_x);
  EXPECT_EQ(onboard.collision_behavior, scenario.onboard.collision_behavior);
  EXPECT_EQ(onboard.guiding_mode, scenario.onboard.guiding_mode);
  EXPECT_EQ(onboard.filters, scenario.onboard.filters);
  EXPECT_EQ(onboard.stiffness_frame.EE_T_K, scenario.onboard.EE_T_K.Matrix());
  EXPECT_EQ(onboard.end_effector_frame.NE_T_EE[14], 0.1);
  EXPECT_EQ(onboard.cartesian.elbow.dp_max, PlanOf(scenario).robot.cartesian.elbow.dp_max);
}

TEST_F(PlanTest, RefusesCommandsToTheHandAfterTheMotion) {
  scenario::Scenario scenario = scenario::Parse(scenario::test::TouchedText(), "s.yaml");
  scenario.hand.back().at = PlanOf(scenario).motion.trajectory.duration();
  EXPECT_THAT(MessageOf(scenario), StartsWith("hand[4].at: "));
  EXPECT_THAT(MessageOf(scenario), HasSubstr("is not before the end of the motion"));
  scenario.hand.back().at -= 1ns;
  EXPECT_EQ(MessageOf(scenario), "(accepted)");
}

TEST_F(PlanTest, TellsTheLinkAllTheScenarioSays) {
  const robot::LinkConfig link = PlanOf(Full()).config.link;
  EXPECT_EQ(link.d_INT, 50us);
  EXPECT_DOUBLE_EQ(link.state.duplication, 0.01);
  EXPECT_DOUBLE_EQ(link.command.duplication, 0.005);
  EXPECT_DOUBLE_EQ(link.state.reordering, 0.003);
  EXPECT_EQ(link.state.reorder_by, 1500us);
  EXPECT_DOUBLE_EQ(link.command.reordering, 0.002);
  EXPECT_EQ(link.command.reorder_by, 2500us);
  EXPECT_EQ(std::get<faults::IndependentLoss>(link.state.loss.parameters()).probability, 0.001);
  EXPECT_EQ(std::get<faults::GilbertElliottLoss>(link.command.loss.parameters()).bad_to_good, 0.25);
  // The two directions' delays are told apart by what they draw.
  const Random random(1, RandomStream::kTest);
  EXPECT_EQ(link.command.delay.Draw(random, 1), 95'500ns);
  EXPECT_EQ(link.command.duplicate_delay.Draw(random, 1), 200us);
  EXPECT_GT(link.state.delay.Draw(random, 1), 20us);
  EXPECT_NE(link.state.delay.Draw(random, 1), link.state.delay.Draw(random, 2));
}

TEST_F(PlanTest, TellsTheTickAllTheScenarioSays) {
  const Plan plan = PlanOf(Full());
  const loop::TickConfig tick = MakeTick(Full(), plan.robot);
  EXPECT_EQ(plan.motion.loop, loop::LoopKind::kAsynchronous);
  EXPECT_EQ(tick.generator, loop::Generator::kNone);
  EXPECT_EQ(tick.lambda, 0.01);
  EXPECT_FALSE(tick.rate_matching);
  EXPECT_EQ(tick.source_rate_hz, 125);
  EXPECT_EQ(tick.finish_tolerance_rad, 0.0002);
  EXPECT_EQ(tick.period_tolerance, 300us);
  EXPECT_EQ(tick.low_pass_hz, 100);
  ASSERT_TRUE(tick.limiter);
  const auto limits = reference::ClientLimits::Of(plan.robot.limits, plan.robot.cartesian);
  EXPECT_EQ(tick.limiter->dq_max, limits.dq_max);
  EXPECT_EQ(tick.limiter->rotation.dp_max, limits.rotation.dp_max);
  EXPECT_EQ(tick.cost.Draw(Random(1, RandomStream::kTest), 1), 13us);
}

TEST_F(PlanTest, TellsTheControllersLoopAllTheScenarioSays) {
  const loop::ControllerLoopConfig config = MakeControllerLoop(PlanOf(Full()).motion.controller);
  EXPECT_EQ(config.rate_hz, 125);
  EXPECT_EQ(config.clock_ppm, -20);
  EXPECT_EQ(config.phase, 250us);
  EXPECT_EQ(config.feed_forward, reference::FeedForwardTime::kNominal);
  EXPECT_EQ(config.target_noise, 0.0005);
  EXPECT_EQ(config.cost.Draw(Random(1, RandomStream::kTest), 1), 100us);
}

TEST_F(PlanTest, RefusesRejoiningBehindALowPass) {
  // The arm would creep with a hundredth of its speed, along another path than planned (world
  // 174617 of the campaign).
  scenario::Scenario scenario = Full();
  scenario.tick.generator = loop::Generator::kRejoining;
  EXPECT_NE(MessageOf(scenario).find("tick.low_pass: "), std::string::npos);
  scenario.tick.low_pass_hz = loop::TickConfig().low_pass_hz;
  scenario.onboard.filters = {.controller_hz = 100};
  EXPECT_EQ(MessageOf(scenario), "(accepted)");
  scenario.onboard.filters.joint_position_hz = 900;
  EXPECT_NE(MessageOf(scenario).find("onboard.filters: "), std::string::npos);
  scenario.tick.generator = loop::Generator::kNone;
  EXPECT_EQ(MessageOf(scenario), "(accepted)");
}

TEST_F(PlanTest, LimitsTorquesAndLeavesTheLowPassOffUnlessAskedFor) {
  const scenario::Scenario scenario = scenario::Parse(scenario::test::OtherText(), "s.yaml");
  const Plan plan = PlanOf(scenario);
  const loop::TickConfig tick = MakeTick(scenario, plan.robot);
  EXPECT_EQ(plan.motion.loop, loop::LoopKind::kSynchronous);
  EXPECT_TRUE(tick.limiter);
  EXPECT_EQ(tick.low_pass_hz, loop::TickConfig().low_pass_hz);
  EXPECT_EQ(tick.period_tolerance, 0s);
}

TEST_F(PlanTest, StartsTheMotionThatGoesWithTheInterface) {
  using control::CommandInterface;
  scenario::Scenario scenario = Full();
  scenario.tick.viability.reset();
  for (const auto& [interface, controller, generator] :
       {std::tuple{CommandInterface::kJointPosition, ControllerMode::kJointImpedance,
                   MotionGeneratorMode::kJointPosition},
        {CommandInterface::kJointVelocity, ControllerMode::kJointImpedance,
         MotionGeneratorMode::kJointVelocity},
        {CommandInterface::kCartesianPose, ControllerMode::kCartesianImpedance,
         MotionGeneratorMode::kCartesianPosition},
        {CommandInterface::kTorque, ControllerMode::kExternalController,
         MotionGeneratorMode::kJointVelocity}}) {
    scenario.motion.interface = interface;
    if (controller != ControllerMode::kExternalController) scenario.motion.controller = controller;
    EXPECT_EQ(PlanOf(scenario).motion.interface, interface);
    EXPECT_EQ(ModesOf(scenario.motion).controller, controller);
    EXPECT_EQ(ModesOf(scenario.motion).generator, generator);
  }
}

/// Reaches below the floor and comes back.
constexpr const char* kBelowTheFloor = R"(name: floor
motion:
  trajectory:
    unit: rad
    waypoints:
      - {q: [0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]}
      - {q: [0, 1.4, 0, -1.0, 0, 1.5708, 0.7854]}
      - {q: [0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]}
)";

TEST_F(PlanTest, RefusesAMotionOnWhichTheArmTouchesSomething) {
  const auto message = [this](const std::string& text) -> std::string {
    try {
      RequireFree(scenario::Parse(text, "s.yaml"), files_);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(message(kBelowTheFloor), StartsWith("motion: at "));
  EXPECT_THAT(message(kBelowTheFloor), HasSubstr("finger and floor overlap"));
  EXPECT_EQ(message(std::string(kBelowTheFloor) + "  touches: to see the reflex\n"), "");
  const std::string box =
      "objects:\n  - {name: wall, shape: box, size: [0.2 m, 0.2 m, 1 m], position: [0.27 m, 0.3 m, 0.5 m]}\n";
  const std::string above =
      scenario::test::Replaced(kBelowTheFloor, "[0, 1.4, 0, -1.0,", "[0.5, -0.7854, 0, -2.3562,");
  EXPECT_EQ(message(above), "");
  EXPECT_THAT(message(above + box), HasSubstr("wall"));
}

TEST_F(PlanTest, NamesTheLineOfANameThatIsUnknown) {
  const auto spoiled = [this](const std::string& from, const std::string& to) {
    return MessageOf(
        scenario::Parse(scenario::test::Replaced(scenario::test::FullText(), from, to), "s.yaml"));
  };
  EXPECT_THAT(spoiled("backend: mujoco", "backend: gazebo"), StartsWith("s.yaml:4: "));
  EXPECT_THAT(spoiled("backend: mujoco", "backend: gazebo"), HasSubstr("gazebo"));
  EXPECT_THAT(spoiled("floor.xml", "nowhere.xml"), StartsWith("s.yaml:7: scene: "));
  EXPECT_THAT(spoiled("model: panda", "model: pandas"), StartsWith("s.yaml:9: robot.model: "));
  EXPECT_THAT(spoiled("joint_trajectory", "pid"), StartsWith("s.yaml:44: "));
  EXPECT_THAT(spoiled("joint_trajectory", "pid"), HasSubstr("joint_trajectory_effort"));
}

TEST_F(PlanTest, NamesNoLineForANameThatIsNotFromTheFile) {
  scenario::Scenario scenario = Full();
  scenario.backend = "gazebo";
  EXPECT_THAT(MessageOf(scenario), ::testing::Not(HasSubstr("s.yaml")));
  scenario = scenario::Parse(scenario::test::OtherText(), "s.yaml");
  scenario.controller.type = "pid";
  EXPECT_THAT(MessageOf(scenario), ::testing::Not(HasSubstr("s.yaml")));
}

}  // namespace
}  // namespace twin::run::run_resolve_test
