#include <chrono>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "twin/core/error.h"
#include "twin/scenario/robot_data.h"
#include "twin/scenario/scenario.h"

namespace twin::scenario::scenario_vacuum_test {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;
using testing::ThrowsMessage;

std::string Text(const std::string& hand, const std::string& commands) {
  return "name: vacuum\nrobot: {hand: " + hand +
         ", q_start: {unit: rad, values: [0, -0.7, 0, -2.3, 0, 1.5, 0.7]}}\n" +
         "motion: {trajectory: {unit: rad, duration: 1 s, waypoints: "
         "[{q: [0, -0.7, 0, -2.3, 0, 1.5, 0.7]}, {q: [0, -0.7, 0, -2.3, 0, 1.5, 0.8]}]}}\n" +
         "hand:\n" + commands;
}

constexpr const char* kCommands =
    "  - {at: 0 s, vacuum: {vacuum: 600 mbar, profile: 2, timeout: 1500 ms}}\n"
    "  - {at: 2 s, drop_off: {timeout: 1 s}}\n"
    "  - {at: 3 s, stop: {}}\n";

TEST(ScenarioVacuumTest, ReadsAndWritesWhatThePumpIsToDo) {
  const Scenario s = Parse(Text("cobot_pump", kCommands), "s.yaml");
  EXPECT_EQ(s.robot.hand, plant::HandKind::kCobotPump);
  EXPECT_EQ(s.hand, (std::vector<HandEvent>{
                        {0s, hand::Vacuum{.vacuum = 60, .profile = 2, .timeout_ms = 1500}},
                        {2s, hand::DropOff{.timeout_ms = 1000}},
                        {3s, hand::Stop{}}}));
  EXPECT_EQ(Parse(ToYaml(s), "again.yaml").hand, s.hand);
}

TEST(ScenarioVacuumTest, RefusesCommandsThatTheMountedHandHasNot) {
  const auto parse = [](const std::string& text) {
    return [text] { (void)Parse(text, "s.yaml"); };
  };
  EXPECT_THAT(parse(Text("franka_hand", kCommands)),
              ThrowsMessage<InputError>(HasSubstr(
                  "hand: at 0 s: Vacuum: the command must be homing, move, grasp or stop")));
  EXPECT_THAT(parse(Text("cobot_pump", "  - {at: 1 s, homing: {}}\n")),
              ThrowsMessage<InputError>(
                  HasSubstr("hand: at 1 s: Homing: the command must be vacuum, drop off or stop")));
}

TEST(ScenarioVacuumTest, RefusesFiguresOutOfRange) {
  const auto parse = [](const std::string& command) {
    return [command] { (void)Parse(Text("cobot_pump", command), "s.yaml"); };
  };
  EXPECT_THAT(parse("  - {at: 0 s, vacuum: {vacuum: 5 mbar, timeout: 1 s}}\n"),
              ThrowsMessage<InputError>(HasSubstr("s.yaml:5: hand[1].vacuum.vacuum: ")));
  EXPECT_THAT(parse("  - {at: 0 s, vacuum: {vacuum: 60, timeout: 1 s}}\n"),
              ThrowsMessage<InputError>(HasSubstr("mbar")));
  EXPECT_THAT(parse("  - {at: 0 s, vacuum: {vacuum: 600 mbar, profile: 4, timeout: 1 s}}\n"),
              ThrowsMessage<InputError>(HasSubstr("hand[1].vacuum.profile: ")));
  EXPECT_THAT(parse("  - {at: 0 s, drop_off: {}}\n"),
              ThrowsMessage<InputError>(HasSubstr("key \"timeout\" is missing")));
}

TEST(ScenarioVacuumTest, TellsTheControllerOfThePumpWhatFrankaDescribes) {
  const RobotData robot = LoadRobotData(std::filesystem::path(TWIN_SOURCE_DIR) / "models", "panda",
                                        plant::HandKind::kCobotPump);
  EXPECT_EQ(robot.end_effector.m, 1.01);
  EXPECT_EQ(robot.end_effector.F_x_C, (Vector3{0, 0, 0.063}));
  EXPECT_EQ(robot.end_effector.I, (Matrix3{0.001, 0, 0, 0, 0.001, 0, 0, 0, 0.001}));
  EXPECT_EQ(robot.F_T_NE, (Transform{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0.105, 1}));
}

}  // namespace
}  // namespace twin::scenario::scenario_vacuum_test
