#include <array>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <numbers>
#include <string>
#include <variant>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenario/scenario_examples.h"
#include "twin/scenario/scenario.h"

namespace twin::scenario::scenario_round_trip_test {
namespace {

using namespace std::chrono_literals;  // NOLINT(google-build-using-namespace): 80us

std::filesystem::path Scenarios() {
  return std::filesystem::path(TWIN_SOURCE_DIR) / "models" / "scenarios";
}

TEST(ScenarioTest, ReadsEveryKey) {
  const Scenario s = Parse(test::FullText(), "s.yaml");
  EXPECT_EQ(s.name, "full");
  EXPECT_EQ(s.seed, 42u);
  EXPECT_EQ(s.robot.hand, plant::HandKind::kNone);
  EXPECT_EQ(s.robot.q_start.value()[1], -std::numbers::pi / 180 * 45);
  EXPECT_EQ(s.plant.kind, robot::PlantKind::kIdeal);
  EXPECT_EQ(s.plant.friction, plant::FrictionProfile::kBreakaway);
  EXPECT_FALSE(s.plant.armature);
  EXPECT_EQ(s.plant.noise_tau_J, 0.3);
  EXPECT_EQ(s.link.state.delay, (Delay{faults::LogNormalDelay{80us, 0.3, 20us}}));
  EXPECT_EQ(s.link.command.delay, (Delay{faults::ConstantDelay{95'500ns}}));
  EXPECT_EQ(s.link.state.loss, Loss{IndependentLoss{0.1}});
  EXPECT_EQ(s.link.command.loss, (Loss{GilbertElliottLoss{0.1, 25, 0.01, 90}}));
  EXPECT_EQ(s.link.state.duplication, (Duplication{1, {faults::GammaDelay{2, 30us, 20us}}}));
  EXPECT_EQ(s.link.command.duplication, (Duplication{0.5, {faults::ConstantDelay{200us}}}));
  EXPECT_EQ(s.link.state.reordering, (Reordering{0.3, 1500us}));
  EXPECT_EQ(s.link.command.reordering, (Reordering{0.2, 2500us}));
  EXPECT_EQ(s.onboard.abort_after_lost, 19u);
  EXPECT_EQ(s.onboard.friction_compensation, 0.8);
  EXPECT_EQ(s.robot.clock_drift_ppm, 5);
  EXPECT_EQ(s.tick.generator, loop::Generator::kNone);
  EXPECT_EQ(s.tick.period_tolerance, 300us);
  EXPECT_EQ(s.tick.low_pass_hz, 100);
  EXPECT_TRUE(s.tick.limiter);
  EXPECT_EQ(s.tick.viability, 12);
  EXPECT_EQ(s.controller.target_noise, 0.0005);
  EXPECT_EQ(s.controller.rate_hz, 125);
  EXPECT_EQ(s.controller.clock_drift_ppm, -20);
  EXPECT_EQ(s.controller.feed_forward, reference::FeedForwardTime::kNominal);
  EXPECT_EQ(s.motion.interface, control::CommandInterface::kJointVelocity);
  EXPECT_EQ(s.motion.timing.duration, std::chrono::milliseconds(4500));
  ASSERT_EQ(s.motion.waypoints.size(), 3u);
  EXPECT_TRUE(s.motion.waypoints[1].stop);
  EXPECT_EQ(s.motion.waypoints[1].where, "s.yaml:62");
  EXPECT_EQ(s.render.camera.lookat[2], 0.4);
  EXPECT_EQ(s.render.camera.track, "panda_hand");
  EXPECT_NEAR(s.render.camera.turn, 10 * std::numbers::pi / 180, 1e-15);
  EXPECT_EQ(s.render.overlays, (std::vector{Overlay::kLimits, Overlay::kTrace}));
  ASSERT_EQ(s.render.insets.size(), 2U);
  EXPECT_EQ(s.render.insets[0].camera.kind, CameraKind::kGripper);
  EXPECT_EQ(s.render.insets[0].corner, PictureCorner::kBottomLeft);
  EXPECT_EQ(s.render.insets[0].share_percent, 25);
  EXPECT_FALSE(s.record);
}

TEST(ScenarioTest, ReadsTheOtherChoices) {
  const Scenario s = Parse(test::OtherText(), "s.yaml");
  EXPECT_EQ(s.drive, Drive::kRealtime);
  EXPECT_EQ(s.loop, loop::LoopKind::kSynchronous);
  EXPECT_EQ(s.tick.stall_time, std::chrono::milliseconds(35));
  EXPECT_EQ(s.motion.interface, control::CommandInterface::kTorque);
  EXPECT_EQ(s.link.state.delay, (Delay{faults::NormalDelay{80us, 4us}}));
  EXPECT_EQ(s.link.command.delay, (Delay{faults::EmpiricalDelay{{0us, 50us, 100us}, {3, 0.5}}}));
  EXPECT_EQ(s.link.state.loss, (Loss{ScriptedLoss{{{0s, 1}, {2s, 20}}}}));
  EXPECT_EQ(s.tick.low_pass_hz, loop::TickConfig().low_pass_hz);
  EXPECT_EQ(s.controller.target_noise, 0.2);
}

TEST(ScenarioTest, ReadsWhatTheRobotCarriesAndIsToldOf) {
  const Scenario s = Parse(test::TouchedText(), "s.yaml");
  EXPECT_EQ(s.robot.load.m_load, 1.5);
  EXPECT_EQ(s.robot.load.F_x_Cload, (Vector3{0.01, 0, 0.08}));
  EXPECT_EQ(s.robot.load.I_load, (Matrix3{0.01, 0.001, 0, 0.001, 0.02, -0.002, 0, -0.002, 0.025}));
  EXPECT_EQ(s.onboard.load.m_load, 0.5);
  EXPECT_EQ(s.onboard.load.F_x_Cload, Vector3{});
  EXPECT_EQ(s.plant.elasticity, plant::ElasticityProfile::kStatic);
}

TEST(ScenarioTest, ReadsAndWritesForHowLongTheRobotMakesUp) {
  EXPECT_EQ(Parse(test::FullText(), "s.yaml").robot.catch_up, 10ms) << "the default";
  const Scenario s = Parse(test::Replaced(test::FullText(), "  clock_drift: 5 ppm",
                                          "  clock_drift: 5 ppm\n  catch_up: 19 ms"),
                           "s.yaml");
  EXPECT_EQ(s.robot.catch_up, 19ms);
  EXPECT_EQ(Parse(ToYaml(s), "s.yaml").robot.catch_up, 19ms);
}

TEST(ScenarioTest, ReadsTheSettingsOfTheRobot) {
  const OnboardSection onboard = Parse(test::TouchedText(), "s.yaml").onboard;
  EXPECT_EQ(onboard.K_x, (Vector6{200, 200, 200, 10, 20, 30}));
  EXPECT_EQ(onboard.EE_T_K.position, (Vector3{0, 0, 0.05}));
  EXPECT_EQ(onboard.NE_T_EE.position, (Vector3{0, 0.01, 0.1}));
  EXPECT_EQ(onboard.guiding_mode.axes, (std::array{true, false, true, false, false, true}));
  EXPECT_FALSE(onboard.guiding_mode.elbow);
  EXPECT_EQ(onboard.filters,
            (setting::Filters{.joint_position_hz = 100, .cartesian_velocity_hz = 50}));
}

TEST(ScenarioTest, TakesAThresholdWithoutSuffixForBothSets) {
  const setting::CollisionBehavior b =
      Parse(test::TouchedText(), "s.yaml").onboard.collision_behavior;
  const setting::CollisionBehavior defaults;
  EXPECT_EQ(b.upper_torque_acc, (JointVector{40, 40, 40, 40, 40, 40, 40}));
  EXPECT_EQ(b.upper_torque_nominal, b.upper_torque_acc);
  EXPECT_EQ(b.lower_torque_acc, (JointVector{25, 25, 22, 20, 19, 17, 14}));
  EXPECT_EQ(b.lower_torque_nominal, defaults.lower_torque_nominal);
  EXPECT_EQ(b.upper_force_acc, (Vector6{60, 60, 60, 30, 31, 32}));
  EXPECT_EQ(b.upper_force_nominal, b.upper_force_acc);
  EXPECT_EQ(b.lower_force_nominal, (Vector6{10, 11, 12, 25, 25, 25}));
  EXPECT_EQ(b.lower_force_acc, defaults.lower_force_acc);
}

TEST(ScenarioTest, ReadsWhatTheHandIsToDo) {
  const Scenario s = Parse(test::TouchedText(), "s.yaml");
  EXPECT_EQ(s.hand, (std::vector<HandEvent>{{0s, hand::Homing{}},
                                            {20ms, hand::Move{.width = 0.07, .speed = 0.1}},
                                            {30ms, hand::Grasp{.width = 0.05,
                                                               .speed = 0.02,
                                                               .force = 40,
                                                               .epsilon_inner = 0.002,
                                                               .epsilon_outer = 0.005}},
                                            {40ms, hand::Stop{}}}));
}

TEST(ScenarioTest, ReadsWhatPushesAndLeadsTheRobot) {
  const Scenario s = Parse(test::TouchedText(), "s.yaml");
  ASSERT_EQ(s.perturbations.size(), 6u);
  EXPECT_EQ(s.perturbations[0],
            (plant::Perturbation(plant::Push{.body = "panda_hand",
                                             .begin = 1s,
                                             .duration = 400ms,
                                             .rise = 50ms,
                                             .force = {0, 30, 0},
                                             .torque = {0, 0, 1},
                                             .point = {0, 0, 0.1},
                                             .frame = plant::ForceFrame::kBody})));
  EXPECT_EQ(s.perturbations[1],
            (plant::Perturbation(plant::HandSpring{.body = "panda_link4",
                                                   .point = {0.001, 0, 0},
                                                   .begin = 2s,
                                                   .duration = 1s,
                                                   .from = Vector3{0.1, 0.2, 0.3},
                                                   .by = {0, 0.05, 0},
                                                   .stiffness = 500,
                                                   .damping = 20,
                                                   .largest_force = 25})));
  EXPECT_EQ(s.perturbations[3],
            (plant::Perturbation(plant::HandSpring{.body = "panda_hand", .begin = 5s})));
  EXPECT_EQ(
      s.perturbations[4],
      (plant::Perturbation(plant::Push{.body = "panda_link6", .motion = 3, .force = {1, 0, 0}})));
  EXPECT_EQ(
      s.perturbations[5],
      (plant::Perturbation(plant::HandSpring{.body = "panda_hand", .begin = 6s, .motion = 1})));
  EXPECT_EQ(s.panel, (std::vector<robot::PanelEvent>{{3s, PanelAction::kPressUserStop},
                                                     {3500ms, PanelAction::kReleaseUserStop}}));
}

TEST(ScenarioTest, TurnsFramesAboutTheFixedAxesInTurn) {
  const double half_pi = std::numbers::pi / 2;
  const auto x_axis = [](const FramePose& pose) {
    const Transform X = pose.Matrix();
    return Vector3{std::round(X[0]), std::round(X[1]), std::round(X[2])};
  };
  EXPECT_EQ(x_axis({{}, {half_pi, 0, 0}}), (Vector3{1, 0, 0}));
  EXPECT_EQ(x_axis({{}, {0, half_pi, 0}}), (Vector3{0, 0, -1}));
  EXPECT_EQ(x_axis({{}, {0, 0, half_pi}}), (Vector3{0, 1, 0}));
  EXPECT_EQ(x_axis({{}, {half_pi, half_pi, 0}}), (Vector3{0, 0, -1}));
  EXPECT_EQ(x_axis({{}, {half_pi, 0, half_pi}}), (Vector3{0, 1, 0}));
  const Transform X = FramePose{{1, 2, 3}, {0.3, -0.4, 0.5}}.Matrix();
  EXPECT_TRUE(IsRigid(X));
  EXPECT_EQ(X[14], 3);
  EXPECT_EQ(FramePose().Matrix(), kIdentityTransform);
}

TEST(ScenarioTest, TakesOffForThresholdsOutOfReach) {
  const std::string text =
      test::Replaced(test::FullText(), "  damping_ratio: 0.7", "  collision_behavior: off");
  const Scenario s = Parse(text, "s.yaml");
  EXPECT_EQ(s.onboard.collision_behavior, NoCollisionBehavior());
  for (const double force : s.onboard.collision_behavior.upper_force_nominal) {
    EXPECT_EQ(force, 1e6);
  }
  EXPECT_EQ(Parse(ToYaml(s), "t.yaml"), s);
}

TEST(ScenarioTest, SaysToTheLinkWhatWasRead) {
  const Scenario s = Parse(test::OtherText(), "s.yaml");
  const auto model = s.link.state.loss.Model();
  const auto& script = std::get<faults::ScriptedLoss>(model.parameters());
  ASSERT_EQ(script.runs.size(), 2u);
  EXPECT_EQ(script.runs[0].first, 0u);
  EXPECT_EQ(script.runs[1].first, 2000u) << "a message a millisecond";
  EXPECT_EQ(script.runs[1].count, 20u);
  const auto independent = s.link.command.loss.Model();
  EXPECT_EQ(std::get<faults::IndependentLoss>(independent.parameters()).probability, 0.02);
  const auto bursts = Parse(test::FullText(), "s.yaml").link.command.loss.Model();
  const auto& chain = std::get<faults::GilbertElliottLoss>(bursts.parameters());
  EXPECT_DOUBLE_EQ(chain.good_to_bad, 0.001);
  EXPECT_DOUBLE_EQ(chain.bad_to_good, 0.25);
  EXPECT_DOUBLE_EQ(chain.loss_good, 0.0001);
  EXPECT_DOUBLE_EQ(chain.loss_bad, 0.9);
}

TEST(ScenarioTest, SurvivesBeingWrittenAndRead) {
  for (const std::string& original : {test::FullText(), test::OtherText(), test::TouchedText()}) {
    const Scenario scenario = Parse(original, "s.yaml");
    const std::string text = ToYaml(scenario);
    EXPECT_EQ(Parse(text, "t.yaml"), scenario) << text;
    EXPECT_EQ(ToYaml(Parse(text, "t.yaml")), text);
  }
}

TEST(ScenarioTest, TellsScenariosApartThatDifferInOneDelay) {
  const Scenario scenario = Parse(test::OtherText(), "s.yaml");
  const Delay::Law laws[] = {faults::ConstantDelay{1us},
                             faults::ConstantDelay{2us},
                             faults::NormalDelay{1us, 2us},
                             faults::NormalDelay{1us, 3us},
                             faults::LogNormalDelay{1us, 0.1, {}},
                             faults::LogNormalDelay{1us, 0.2, {}},
                             faults::GammaDelay{1, 1us, {}},
                             faults::GammaDelay{2, 1us, {}},
                             faults::EmpiricalDelay{{0s, 1us}, {1}},
                             faults::EmpiricalDelay{{0s, 2us}, {1}}};
  for (const Delay::Law& a : laws) {
    for (const Delay::Law& b : laws) {
      Scenario first = scenario;
      Scenario second = scenario;
      first.tick.cost.law = a;
      second.tick.cost.law = b;
      EXPECT_EQ(first == second, &a == &b) << ToYaml(first) << ToYaml(second);
      EXPECT_EQ(Parse(ToYaml(first), "t.yaml").tick.cost, first.tick.cost);
    }
  }
}

TEST(ScenarioTest, WritesTextsThatYamlWouldMistake) {
  Scenario scenario = Parse(test::FullText(), "s.yaml");
  for (const char* text : {"", "true", "a: b # c", "\"quoted\" \\ back", "two\nlines\ttab\x01",
                           "- [x", "\xc3\xa4\xc3\xb6\xc3\xbc"}) {
    scenario.description = text;
    EXPECT_EQ(Parse(ToYaml(scenario), "t.yaml").description, text);
  }
}

TEST(ScenarioTest, TakesDefaultsForWhatIsNotGiven) {
  const Scenario s = Parse(
      "name: a\nmotion:\n  trajectory:\n    unit: rad\n    waypoints:\n"
      "      - {q: [0, 0, 0, -1, 0, 1, 0]}\n      - {q: [0, 0, 0, -2, 0, 1, 0]}\n",
      "s.yaml");
  EXPECT_EQ(s.onboard, OnboardSection{});
  EXPECT_EQ(s.link, LinkSection{});
  EXPECT_EQ(s.controller, ControllerSection{});
  EXPECT_EQ(s.backend, "mujoco");
}

TEST(ScenarioTest, TakesTheDefaultsThatGoWithLoopAndInterface) {
  const auto with = [](const std::string& loop, const std::string& interface) {
    return Parse("name: a\nloop: " + loop + "\nmotion:\n  interface: " + interface +
                     "\n  trajectory:\n    unit: rad\n    waypoints:\n"
                     "      - {q: [0, 0, 0, -1, 0, 1, 0]}\n      - {q: [0, 0, 0, -2, 0, 1, 0]}\n",
                 "s.yaml");
  };
  EXPECT_EQ(with("asynchronous", "joint_position").tick, TickSection{});
  EXPECT_EQ(with("asynchronous", "joint_position").controller.type, "joint_trajectory");
  EXPECT_EQ(with("asynchronous", "joint_position").tick.period_tolerance, 0s);
  EXPECT_EQ(with("synchronous", "joint_position").tick.period_tolerance, 0s);
  EXPECT_EQ(with("bare", "joint_velocity").tick.period_tolerance, 0s);
  EXPECT_EQ(with("bare", "joint_velocity").tick.generator, loop::Generator::kRejoining);
  EXPECT_EQ(with("bare", "joint_velocity").controller.type, "joint_trajectory");
  EXPECT_EQ(with("asynchronous", "cartesian_pose").tick.generator, loop::Generator::kRejoining);
  EXPECT_EQ(with("asynchronous", "cartesian_pose").tick.viability, 19);
  EXPECT_EQ(with("asynchronous", "cartesian_pose").controller.type, "joint_trajectory");
  EXPECT_EQ(with("asynchronous", "cartesian_pose").motion.controller,
            ControllerMode::kJointImpedance);
  EXPECT_EQ(with("asynchronous", "torque").tick, TorqueTick());
  EXPECT_EQ(with("asynchronous", "torque").controller.type, "joint_trajectory_effort");
}

TEST(ScenarioTest, RemembersWhereItsNamesWereRead) {
  const Scenario s = Parse(test::FullText(), "s.yaml");
  EXPECT_EQ(s.places.backend.where, "s.yaml:4");
  EXPECT_EQ(s.places.scene.where, "s.yaml:7");
  EXPECT_EQ(s.places.robot.where, "s.yaml:9");
  EXPECT_EQ(s.places.controller.where, "s.yaml:44");
  EXPECT_EQ(s.places.controller.name, "joint_trajectory");
  EXPECT_EQ(Parse(test::OtherText(), "s.yaml").places.backend.where, "");
}

TEST(ScenarioTest, TheFormatAsDocumentedHoldsTheDefaults) {
  std::ifstream file(Scenarios() / "README.md");
  std::string text(std::istreambuf_iterator<char>(file), {});
  const std::string fence = "```yaml\n";
  const auto begin = text.find(fence) + fence.size();
  text = text.substr(begin, text.find("\n```", begin) - begin);
  const std::string trajectory =
      " {unit: rad, waypoints: [{q: [0, 0, 0, -1, 0, 1, 0]}, {q: [0, 0, 0, -2, 0, 1, 0]}]}";
  text = test::Replaced(text, "name: \u2026", "name: a");
  text = test::Replaced(text, "q_start: \u2026", "# q_start: ");
  text = test::Replaced(text, "trajectory: \u2026", "trajectory:" + trajectory + "  ");
  EXPECT_EQ(ToYaml(Parse(text, "README.md")),
            ToYaml(Parse("name: a\nmotion:\n  trajectory:" + trajectory + "\n", "s.yaml")));
}

TEST(ScenarioTest, EveryExampleLoadsAndSurvivesTheRoundTrip) {
  std::size_t examples = 0;
  for (const auto& entry : std::filesystem::directory_iterator(Scenarios())) {
    if (entry.path().extension() != ".yaml" || entry.path().stem().extension() == ".hash") continue;
    SCOPED_TRACE(entry.path());
    const Scenario scenario = Load(entry.path());
    EXPECT_EQ(Parse(ToYaml(scenario), "t.yaml"), scenario);
    EXPECT_EQ(scenario.name, entry.path().stem().string());
    ++examples;
  }
  EXPECT_GE(examples, 5u);
}

}  // namespace
}  // namespace twin::scenario::scenario_round_trip_test
