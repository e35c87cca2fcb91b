#include <filesystem>
#include <ostream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenario/scenario_examples.h"
#include "twin/core/error.h"
#include "twin/scenario/scenario.h"

namespace twin::scenario {
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
                "s.yaml:28: tick: ", "unknown key \"lamda\"; did you mean \"lambda\"?"},
        Spoiled{"UnknownKeyAtTheRoot", "seed: 42", "sead: 42",
                "s.yaml:3: ", "unknown key \"sead\"; did you mean \"seed\"? accepted: name,"},
        Spoiled{"DuplicateKey", "  lambda: 0.01", "  lambda: 0.01\n  lambda: 0.02",
                "s.yaml:29: tick.lambda: ", "given twice; first in line 28"},
        Spoiled{"MissingKey", "name: full\n", "", "s.yaml:1: ", "key \"name\" is missing"},
        Spoiled{"MapInsteadOfValue", "seed: 42", "seed: {a: 1}",
                "s.yaml:3: seed: ", "is a map; a whole number belongs here"},
        Spoiled{"ValueInsteadOfMap", "  noise: {q: 0.001 deg, dq: 0.002 rad/s, tau_J: 0.3 Nm}",
                "  noise: 3", "s.yaml:15: plant.noise: ", "is a single value; a map with the keys"},
        Spoiled{"EmptyValue", "  cost: 13 us", "  cost:", "s.yaml:30: tick.cost: ", "is empty"},
        Spoiled{"NotYaml", "robot:", "robot: [", "s.yaml:", "not valid YAML"},
        Spoiled{"ListAsKey", "seed: 42", "[seed]: 42", "s.yaml:3: ", "a key must be a plain word"},
        Spoiled{"BothDelays", "{constant: 95.5 us}",
                "{constant: 1 us, log_normal: {median: 1 us, sigma: 1}}",
                "s.yaml:18: link.command_delay: ", "exactly one of constant and log_normal"}),
    [](const auto& info) { return info.param.claim; });

INSTANTIATE_TEST_SUITE_P(
    Units, ScenarioErrorsTest,
    ::testing::Values(
        Spoiled{"WrongUnit", "d_INT: 50 us", "d_INT: 50 Hz", "s.yaml:21: link.d_INT: ",
                "unit \"Hz\" does not fit a time; write it like \"500 us\" (units: ns, us"},
        Spoiled{"NoUnit", "rate: 125 Hz", "rate: 125", "s.yaml:33: controller.rate: ",
                "\"125\" has no unit; a frequency is written like \"1000 Hz\""},
        Spoiled{"WrongUnitOfAList", "unit: Nm/rad", "unit: Nm",
                "s.yaml:23: int.K_theta.unit: ", "unit \"Nm\" does not fit a stiffness"},
        Spoiled{"WrongUnitOfTheWaypoints", "    unit: deg", "    unit: m",
                "s.yaml:42: motion.trajectory.unit: ", "unit \"m\" does not fit an angle"},
        Spoiled{"UnitWhereNoneBelongs", "lambda: 0.01", "lambda: 0.01 s",
                "s.yaml:28: tick.lambda: ", "\"0.01 s\" is not a plain finite number"}),
    [](const auto& info) { return info.param.claim; });

INSTANTIATE_TEST_SUITE_P(
    Values, ScenarioErrorsTest,
    ::testing::Values(
        Spoiled{"WordForNumber", "damping_ratio: 0.7", "damping_ratio: soft",
                "s.yaml:24: int.damping_ratio: ", "\"soft\" is not a plain finite number"},
        Spoiled{"NotANumber", "lambda: 0.01", "lambda: .nan",
                "s.yaml:28: tick.lambda: ", "not a plain finite number"},
        Spoiled{"WaypointNotANumber", "[10, -40, 5,", "[10, .nan, 5,",
                "s.yaml:49: motion.trajectory.waypoints[2].q[2]: ", "not a plain finite number"},
        Spoiled{"WaypointTooShort", "[10, -40, 5, -130, 0, 95, 40]", "[10, -40]",
                "s.yaml:49: motion.trajectory.waypoints[2].q: ", "has 2 values; it needs 7"},
        Spoiled{"OutOfRange", "state_loss: 0.1 %", "state_loss: 101 %",
                "s.yaml:19: link.state_loss",
                "\"101 %\" is out of range; it must lie in [0, 100] %"},
        Spoiled{"NegativeTime", "phase: 250 us", "phase: -1 us", "s.yaml:35: controller.phase: ",
                "\"-1 us\" is out of range; it must lie in [0 s, 10 s]"},
        Spoiled{"StiffnessOutOfRange", "1999.5", "14251", "s.yaml:23: int.K_theta: ",
                "14251 Nm/rad is out of range; each must lie in [0, 14250]"},
        Spoiled{"FractionForInteger", "seed: 42", "seed: 1.5",
                "s.yaml:3: seed: ", "\"1.5\" is not a whole number"},
        Spoiled{"NegativeSeed", "seed: 42", "seed: -1",
                "s.yaml:3: seed: ", "is not a whole number"},
        Spoiled{"OddPictureWidth", "width: 320", "width: 321", "s.yaml:1: ", "both must be even"},
        Spoiled{"YesForTrue", "armature: false", "armature: no",
                "s.yaml:14: plant.armature: ", "\"no\" is neither true nor false"},
        Spoiled{"MisspelledChoice", "friction: breakaway", "friction: breakawy",
                "s.yaml:13: plant.friction: ",
                "\"breakawy\" is unknown; did you mean \"breakaway\"? accepted: none, residual"},
        Spoiled{"NameWithSlash", "name: full", "name: ../full", "s.yaml:1: ", "is no name"},
        Spoiled{"OnePoint",
                "      - {q: [10, -40, 5, -130, 0, 95, 40], stop: true}\n"
                "      - {q: [0, -45, 0, -135, 0, 90, 45]}\n",
                "", "s.yaml:1: ", "1 waypoints; a trajectory needs at least two"},
        Spoiled{"RealtimeDrive", "drive: lockstep", "drive: realtime",
                "s.yaml:5: drive: ", "not part of this version"},
        Spoiled{"UnknownDrive", "drive: lockstep", "drive: warp", "s.yaml:5: drive: ", "unknown"}),
    [](const auto& info) { return info.param.claim; });

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
}  // namespace twin::scenario
