#include <filesystem>
#include <ostream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenario/scenario_examples.h"
#include "twin/core/error.h"
#include "twin/scenario/scenario.h"

namespace twin::scenario::scenario_errors_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

/// One way to spoil a good scenario, and what the message must say.
struct Spoiled {
  const char* claim;
  std::string from;
  std::string to;
  std::string place;  ///< file, line and key the message must start with
  std::string says;
};

std::string MessageOf(const std::string& text) {
  try {
    (void)Parse(text, "s.yaml");
  } catch (const InputError& error) {
    return error.what();
  }
  return "(accepted)";
}

void PrintTo(const Spoiled& spoiled, std::ostream* out) {
  *out << spoiled.claim;
}

class ScenarioErrorsTest : public ::testing::TestWithParam<Spoiled> {};

TEST_P(ScenarioErrorsTest, NamesPlaceValueAndCure) {
  const Spoiled& spoiled = GetParam();
  const std::string message = MessageOf(test::Replaced(test::FullText(), spoiled.from, spoiled.to));
  EXPECT_THAT(message, ::testing::StartsWith(spoiled.place));
  EXPECT_THAT(message, HasSubstr(spoiled.says));
  EXPECT_EQ(message.find('\n'), std::string::npos) << message;
}

INSTANTIATE_TEST_SUITE_P(
    Structure, ScenarioErrorsTest,
    ::testing::Values(
        Spoiled{"UnknownKey", "  lambda: 0.01", "  lamda: 0.01",
                "s.yaml:35: tick: ", "unknown key \"lamda\"; did you mean \"lambda\"?"},
        Spoiled{"UnknownKeyAtTheRoot", "seed: 42", "sead: 42",
                "s.yaml:3: ", "unknown key \"sead\"; did you mean \"seed\"? accepted: name,"},
        Spoiled{"DuplicateKey", "  lambda: 0.01", "  lambda: 0.01\n  lambda: 0.02",
                "s.yaml:36: tick.lambda: ", "given twice; first in line 35"},
        Spoiled{"MissingKey", "name: full\n", "", "s.yaml:1: ", "key \"name\" is missing"},
        Spoiled{"MapInsteadOfValue", "seed: 42", "seed: {a: 1}",
                "s.yaml:3: seed: ", "is a map; a whole number belongs here"},
        Spoiled{"ValueInsteadOfMap", "  noise: {q: 0.001 deg, dq: 0.002 rad/s, tau_J: 0.3 Nm}",
                "  noise: 3", "s.yaml:17: plant.noise: ", "is a single value; a map with the keys"},
        Spoiled{"EmptyValue", "  cost: 13 us", "  cost:", "s.yaml:42: tick.cost: ", "is empty"},
        Spoiled{"NotYaml", "robot:", "robot: [", "s.yaml:", "not valid YAML"},
        Spoiled{"NotEvenAnEscape", "seed: 42", "seed: \"\\\x01\"",
                "s.yaml:", "not valid YAML: unknown escape character: ?"},
        Spoiled{"ListAsKey", "seed: 42", "[seed]: 42", "s.yaml:3: ", "a key must be a plain word"},
        Spoiled{"BothDelays", "{constant: 95.5 us}",
                "{constant: 1 us, log_normal: {median: 1 us, sigma: 1}}",
                "s.yaml:20: link.command_delay: ",
                "exactly one of constant, normal, log_normal, gamma, histogram"},
        Spoiled{"NoDelay", "{constant: 95.5 us}", "{}",
                "s.yaml:20: link.command_delay: ", "give exactly one of constant"},
        Spoiled{"UnknownLoss", "{gilbert_elliott: {", "{gilbert_eliott: {",
                "s.yaml:22: link.command_loss: ", "did you mean \"gilbert_elliott\"?"},
        Spoiled{
            "LossWithoutAParameter", "good_to_bad: 0.1 %, ", "",
            "s.yaml:22: link.command_loss.gilbert_elliott: ", "key \"good_to_bad\" is missing"}),
    [](const auto& info) { return info.param.claim; });

INSTANTIATE_TEST_SUITE_P(
    Units, ScenarioErrorsTest,
    ::testing::Values(
        Spoiled{"WrongUnit", "d_INT: 50 us", "d_INT: 50 Hz", "s.yaml:27: link.d_INT: ",
                "unit \"Hz\" does not fit a time; write it like \"500 us\" (units: ns, us"},
        Spoiled{"NoUnit", "rate: 125 Hz", "rate: 125", "s.yaml:45: controller.rate: ",
                "\"125\" has no unit; a frequency is written like \"1000 Hz\""},
        Spoiled{"WrongUnitOfAList", "unit: Nm/rad", "unit: Nm",
                "s.yaml:29: onboard.K_theta.unit: ", "unit \"Nm\" does not fit a stiffness"},
        Spoiled{"WrongUnitOfTheWaypoints", "    unit: deg", "    unit: m",
                "s.yaml:55: motion.trajectory.unit: ", "unit \"m\" does not fit an angle"},
        Spoiled{"UnitWhereNoneBelongs", "lambda: 0.01", "lambda: 0.01 s",
                "s.yaml:35: tick.lambda: ", "\"0.01 s\" is not a plain finite number"}),
    [](const auto& info) { return info.param.claim; });

INSTANTIATE_TEST_SUITE_P(
    Values, ScenarioErrorsTest,
    ::testing::Values(
        Spoiled{"WordForNumber", "damping_ratio: 0.7", "damping_ratio: soft",
                "s.yaml:30: onboard.damping_ratio: ", "\"soft\" is not a plain finite number"},
        Spoiled{"NotANumber", "lambda: 0.01", "lambda: .nan",
                "s.yaml:35: tick.lambda: ", "not a plain finite number"},
        Spoiled{"WaypointNotANumber", "[10, -40, 5,", "[10, .nan, 5,",
                "s.yaml:62: motion.trajectory.waypoints[2].q[2]: ", "not a plain finite number"},
        Spoiled{"WaypointTooShort", "[10, -40, 5, -130, 0, 95, 40]", "[10, -40]",
                "s.yaml:62: motion.trajectory.waypoints[2].q: ", "has 2 values; it needs 7"},
        Spoiled{"OutOfRange", "state_loss: 0.1 %", "state_loss: 101 %",
                "s.yaml:21: link.state_loss",
                "\"101 %\" is out of range; it must lie in [0, 100] %"},
        Spoiled{"NegativeTime", "phase: 250 us", "phase: -1 us", "s.yaml:47: controller.phase: ",
                "\"-1 us\" is out of range; it must lie in [0 s, 10 s]"},
        Spoiled{"StiffnessOutOfRange", "1999.5", "14251", "s.yaml:29: onboard.K_theta: ",
                "K_theta[6] is 14251; it must be in [0, 14250] Nm/rad"},
        Spoiled{"FractionForInteger", "seed: 42", "seed: 1.5",
                "s.yaml:3: seed: ", "\"1.5\" is not a whole number"},
        Spoiled{"NegativeSeed", "seed: 42", "seed: -1",
                "s.yaml:3: seed: ", "is not a whole number"},
        Spoiled{"OddPictureWidth", "width: 320", "width: 321", "s.yaml:1: ", "both must be even"},
        Spoiled{"YesForTrue", "armature: false", "armature: no",
                "s.yaml:16: plant.armature: ", "\"no\" is neither true nor false"},
        Spoiled{"MisspelledChoice", "friction: breakaway", "friction: breakawy",
                "s.yaml:15: plant.friction: ",
                "\"breakawy\" is unknown; did you mean \"breakaway\"? accepted: none, residual"},
        Spoiled{"NameWithSlash", "name: full", "name: ../full", "s.yaml:1: ", "is no name"},
        Spoiled{"OnePoint",
                "      - {q: [10, -40, 5, -130, 0, 95, 40], stop: true}\n"
                "      - {q: [0, -45, 0, -135, 0, 90, 45]}\n",
                "", "s.yaml:1: ", "1 waypoints; a trajectory needs at least two"},
        Spoiled{"RemoteDrive", "drive: lockstep", "drive: remote", "s.yaml:5: drive: ",
                "\"remote\" repeats backend fci: write backend: fci and no drive"},
        Spoiled{"OldNameOfOnboard", "\nonboard:", "\nint:", "s.yaml:28: int: ",
                "this section is called onboard now; rename it"},
        Spoiled{"UnknownLoop", "loop: asynchronous", "loop: async", "s.yaml:6: loop: ",
                "\"async\" is unknown; accepted: asynchronous, synchronous, bare"},
        Spoiled{"DriftOutOfRange", "clock_drift: 5 ppm", "clock_drift: -1001 ppm",
                "s.yaml:12: robot.clock_drift: ", "it must lie in [-1000, 1000] ppm"},
        Spoiled{"CompensationOutOfRange", "friction_compensation: 0.8",
                "friction_compensation: 1.1", "s.yaml:32: onboard.friction_compensation: ",
                "1.1 is out of range; it must lie in [0, 1]"},
        Spoiled{"EndlessBurst", "bad_to_good: 25 %", "bad_to_good: 0 %",
                "s.yaml:22: link.command_loss: ", "else a burst never ends"},
        Spoiled{"LossAboveAll", "loss_bad: 90 %", "loss_bad: 190 %",
                "s.yaml:22: link.command_loss.gilbert_elliott.loss_bad: ", "[0, 100] %"},
        Spoiled{"ReorderingByNothing", "by: 1.5 ms", "by: 0 s",
                "s.yaml:25: link.state_reordering: ", "by is 0 s, which holds nothing back"},
        Spoiled{"NoShapeOfAGamma", "{shape: 2, ", "{shape: 0, ",
                "s.yaml:23: link.state_duplication.delay.gamma.shape: ", "0 is out of range"},
        Spoiled{"ToleranceOfMoreThanACycle", "period_tolerance: 300 us", "period_tolerance: 2 ms",
                "s.yaml:38: tick.period_tolerance: ", "it must lie in [0 s, 1 ms]"},
        Spoiled{"ToleranceOfAnotherLoop", "loop: asynchronous", "loop: synchronous",
                "s.yaml:38: tick.period_tolerance: ", "only the asynchronous loop has one"},
        Spoiled{"CutOffAboveTheRate", "low_pass: 100 Hz", "low_pass: 1001 Hz",
                "s.yaml:39: tick.low_pass: ", "it must lie in [1, 1000] Hz"},
        Spoiled{"CutOffInWords", "low_pass: 100 Hz", "low_pass: none",
                "s.yaml:39: tick.low_pass: ", "\"none\" is not a frequency"},
        Spoiled{"GeneratorOfAnotherInterface", "generator: none", "generator: joint",
                "s.yaml:34: tick.generator: ",
                "joint makes joint positions, and motion.interface is joint_velocity"},
        Spoiled{"GeneratorOfPoses", "generator: none", "generator: cartesian",
                "s.yaml:34: tick.generator: ",
                "cartesian makes poses, and motion.interface is joint_velocity"},
        Spoiled{"UnknownGenerator", "generator: none", "generator: spline",
                "s.yaml:34: tick.generator: ",
                "\"spline\" is unknown; accepted: none, joint, rejoining, cartesian"},
        Spoiled{"MoreLossesThanTheFilterBridges", "viability: 12", "viability: 200",
                "s.yaml:41: tick.viability: ", "[0, 100]"},
        Spoiled{"UnknownOverlay", "overlays: [limits, trace]", "overlays: [limits, fog]",
                "s.yaml:76: render.overlays[2]: ", "accepted: text, goal, trace"},
        Spoiled{"InsetWithoutCamera", "{camera: gripper, corner: bottom_left",
                "{corner: bottom_left", "s.yaml:78: render.insets[1]", "camera"},
        Spoiled{"NoiseOfAnotherInterface", "target_noise: 0.0005 rad/s", "target_noise: 0.0005 rad",
                "s.yaml:51: controller.target_noise: ", "\"rad\" does not fit an angular velocity"},
        Spoiled{"UnknownDrive", "drive: lockstep", "drive: warp", "s.yaml:5: drive: ", "unknown"}),
    [](const auto& info) { return info.param.claim; });

/// OtherText() with one change, and where and what the message must say.
void ExpectRefused(const std::string& from, const std::string& to, const std::string& place,
                   const std::string& says) {
  const std::string message = MessageOf(test::Replaced(test::OtherText(), from, to));
  EXPECT_THAT(message, ::testing::StartsWith(place));
  EXPECT_THAT(message, HasSubstr(says));
}

/// TouchedText() with one change, and where and what the message must say.
void ExpectTouchedRefused(const std::string& from, const std::string& to, const std::string& place,
                          const std::string& says) {
  const std::string message = MessageOf(test::Replaced(test::TouchedText(), from, to));
  EXPECT_THAT(message, ::testing::StartsWith(place));
  EXPECT_THAT(message, HasSubstr(says));
}

TEST(ScenarioErrorsTest, RefusesALoadThatCannotBe) {
  ExpectTouchedRefused("{mass: 1.5 kg, ", "{", "s.yaml:3: robot.load: ", "key \"mass\" is missing");
  ExpectTouchedRefused("mass: 1.5 kg", "mass: -1 kg",
                       "s.yaml:3: robot.load.mass: ", "it must lie in [0, 100] kg");
  ExpectTouchedRefused("[10 mm, 0 m, 0.08 m]", "[10 mm, 0 m]",
                       "s.yaml:3: robot.load.position: ", "has 2 values; it needs 3: x, y, z");
  ExpectTouchedRefused("mass: 500 g", "mass: 500 N",
                       "s.yaml:13: onboard.load.mass: ", "\"N\" does not fit a mass");
  ExpectTouchedRefused("{mass: 500 g}",
                       "{mass: 500 g, products_of_inertia: [1 kg m^2, 0 kg m^2, 0 kg m^2]}",
                       "s.yaml:13: onboard.load: ", "load_inertia must be that of a body");
  ExpectTouchedRefused("0.025 kg m^2]", "0.04 kg m^2]",
                       "s.yaml:3: robot.load: ", "load_inertia must be that of a body");
}

TEST(ScenarioErrorsTest, RefusesSettingsTheRobotWouldRefuse) {
  ExpectTouchedRefused("translation: 200 N/m", "translation: 5 N/m",
                       "s.yaml:7: onboard.K_x.translation: ", "it must lie in [10, 3000] N/m");
  ExpectTouchedRefused("rotation: [10", "rotation: [301",
                       "s.yaml:7: onboard.K_x.rotation[1]: ", "it must lie in [1, 300] Nm/rad");
  ExpectTouchedRefused("values: [40, 40", "values: [40, 10",
                       "s.yaml:8: onboard.collision_behavior: ",
                       "lower_torque_thresholds_acceleration[1] is 25; it must be at most");
  ExpectTouchedRefused(
      "force: 60 N", "force: 60 Nm",
      "s.yaml:11: onboard.collision_behavior.upper_force.force: ", "\"Nm\" does not fit a force");
  ExpectTouchedRefused("[x, z, Y]", "[x, z, yaw]", "s.yaml:16: onboard.guiding_mode.axes[3]: ",
                       "\"yaw\" is unknown; accepted: x, y, z, R, P, Y");
  ExpectTouchedRefused(
      "joint_position: 100 Hz", "joint_position: 2 kHz",
      "s.yaml:17: onboard.filters.joint_position: ", "it must lie in [1, 1000] Hz");
}

TEST(ScenarioErrorsTest, RefusesPerturbationsThatCannotBe) {
  ExpectTouchedRefused("elasticity: static", "kind: ideal",
                       "s.yaml:1: ", "perturbations: the ideal plant feels no forces");
  ExpectTouchedRefused("- push: {body: panda_hand, ", "- push: {",
                       "s.yaml:32: perturbations[1].push: ", "key \"body\" is missing");
  ExpectTouchedRefused("rise: 50 ms", "rise: 250 ms", "s.yaml:32: perturbations[1].push: ",
                       "rise is 0.25 s; rise and fall take as long");
  ExpectTouchedRefused("begin: 4 s, torque: [1 Nm, 0 Nm, 0 Nm]", "begin: 4 s",
                       "s.yaml:34: perturbations[3].push: ", "give a force, a torque or both");
  ExpectTouchedRefused("- push", "- shove", "s.yaml:32: perturbations[1]", "shove");
  ExpectTouchedRefused("frame: body", "frame: hand",
                       "s.yaml:32: perturbations[1].push.frame: ", "accepted: world, body");
  ExpectTouchedRefused(
      "damping: 20 Ns/m", "damping: 20 N/m",
      "s.yaml:33: perturbations[2].spring.damping: ", "\"N/m\" does not fit a damping");
  ExpectTouchedRefused("motion: 3", "motion: 0",
                       "s.yaml:36: perturbations[5].push.motion: ", "[1, 1000000]");
  ExpectTouchedRefused("motion: 1}", "motion: first}",
                       "s.yaml:37: perturbations[6].spring.motion: ", "first");
}

TEST(ScenarioErrorsTest, RefusesAPanelThatDoesNotWork) {
  ExpectTouchedRefused("at: 3.5 s", "at: 2.5 s",
                       "s.yaml:40: panel[2].at: ", "comes before the event above it");
  ExpectTouchedRefused("press_user_stop", "push_user_stop",
                       "s.yaml:39: panel[1].action: ", "did you mean \"press_user_stop\"?");
}

TEST(ScenarioErrorsTest, RefusesCommandsNoHandTakes) {
  ExpectTouchedRefused("width: 70 mm", "width: 90 mm", "s.yaml:43: hand[2].move: ",
                       "width is 0.09; it must be in [0, the hand's largest opening] m");
  ExpectTouchedRefused("speed: 0.1 m/s", "speed: 0 m/s", "s.yaml:43: hand[2].move: ",
                       "speed is 0; it must be finite and above 0 m/s");
  ExpectTouchedRefused("force: 40 N", "force: 150 N", "s.yaml:44: hand[3].grasp: ",
                       "force is 150; it must be above 0 and at most 140 N");
  ExpectTouchedRefused("epsilon_inner: 2 mm", "epsilon_inner: -2 mm",
                       "s.yaml:44: hand[3].grasp: ", "epsilon_inner is -0.002");
  ExpectTouchedRefused("force: 40 N", "force: 40 Nm",
                       "s.yaml:44: hand[3].grasp.force: ", "\"Nm\" does not fit a force");
  ExpectTouchedRefused(", force: 40 N", "",
                       "s.yaml:44: hand[3].grasp: ", "key \"force\" is missing");
}

TEST(ScenarioErrorsTest, RefusesAHandSectionThatDoesNotWork) {
  ExpectTouchedRefused("at: 30 ms", "at: 10 ms",
                       "s.yaml:44: hand[3].at: ", "comes before the command above it");
  ExpectTouchedRefused("stop: {}", "let_go: {}", "s.yaml:45: hand[4]", "let_go");
  ExpectTouchedRefused("stop: {}", "stop: {}, homing: {}", "s.yaml:45: hand[4]: ",
                       "give exactly one of homing, move, grasp, vacuum, drop_off, stop");
  ExpectTouchedRefused(", stop: {}", "", "s.yaml:45: hand[4]: ",
                       "give exactly one of homing, move, grasp, vacuum, drop_off, stop");
  for (const char* value : {"now", "{force: 3 N}", "[1]"}) {
    ExpectTouchedRefused("homing: {}", std::string("homing: ") + value,
                         "s.yaml:42: hand[1].homing: ", "takes no values; write {}");
  }
  ExpectTouchedRefused("robot:\n", "robot:\n  hand: none\n",
                       "s.yaml:1: ", "hand: robot.hand is none, so there is nothing to command");
}

TEST(ScenarioErrorsTest, RefusesAControllerWhereTorquesAreCommanded) {
  ExpectTouchedRefused("interface: cartesian_pose", "interface: torque",
                       "s.yaml:25: motion.controller: ", "the commanded torque takes its place");
}

TEST(ScenarioErrorsTest, RefusesAScriptThatNamesNoMessages) {
  ExpectRefused("at: 2 s", "at: 2.0005 s", "s.yaml:7: link.state_loss.scripted[2].at: ",
                "messages are 1 ms apart; give a whole number of ms");
  ExpectRefused("count: 20", "count: 0", "s.yaml:7: link.state_loss.scripted[2].count: ",
                "\"0\" is not a whole number in [1, ");
  ExpectRefused("at: 2 s", "at: 0 s", "s.yaml:7: link.state_loss: ", "rising order");
}

TEST(ScenarioErrorsTest, RefusesAHistogramWithoutShape) {
  const std::string place = "s.yaml:6: link.command_delay: ";
  ExpectRefused("[3, 0.5]", "[3]", place, "there are 3 edges and 1 weights");
  ExpectRefused("[3, 0.5]", "[0, 0]", place, "all weights are 0");
  ExpectRefused("[0 us, 50 us,", "[0 us, 150 us,", place, "edges must rise");
}

TEST(ScenarioErrorsTest, RefusesAClockForTheLoopThatHasNone) {
  ExpectRefused("loop: synchronous", "loop: bare",
                "s.yaml:1: ", "controller: the bare loop is paced by the robot, at 1000 Hz");
}

/// Comparing each key with all before it would take longer than a test may.
TEST(ScenarioErrorsTest, RefusesManyParametersInLinearTime) {
  std::string text = "name: a\ncontroller:\n  type: b\n  parameters:\n";
  for (int i = 1; i <= 700'000; ++i) text += "    p" + std::to_string(i) + ": 1\n";
  text +=
      "motion:\n  trajectory: {unit: rad, waypoints: [{q: [0, 0, 0, -2, 0, 2, 0]}, "
      "{q: [0, 0, 0, -2, 0, 2, 0.1]}]}\n";
  EXPECT_EQ(MessageOf(text), "s.yaml:1005: controller.parameters.p1001: more than 1000 parameters");
}

TEST(ScenarioFileTest, NamesAMissingFile) {
  EXPECT_THAT([] { (void)Load("/nonexistent/s.yaml"); },
              ::testing::ThrowsMessage<InputError>(
                  AllOf(HasSubstr("/nonexistent/s.yaml: "), HasSubstr("existing YAML file"))));
}

TEST(ScenarioFileTest, RefusesAFolder) {
  EXPECT_THROW((void)Load(std::filesystem::temp_directory_path()), InputError);
}

TEST(ScenarioFileTest, NamesAMissingTrajectoryFile) {
  const std::string text = "name: a\nmotion:\n  trajectory: nowhere.yaml\n";
  EXPECT_THAT(MessageOf(text), HasSubstr("nowhere.yaml: "));
}

TEST(ScenarioFileTest, RefusesATrajectoryFileOfAnotherKind) {
  const std::string text = "name: a\nmotion:\n  trajectory: path.txt\n";
  EXPECT_THAT(MessageOf(text), HasSubstr("s.yaml:3: motion.trajectory: \"path.txt\" is no "
                                         "trajectory file; its name must end in .yaml or .csv"));
}

}  // namespace
}  // namespace twin::scenario::scenario_errors_test
