#include "twin/scenario/cell.h"

#include <string>
#include <string_view>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "twin/core/error.h"

namespace twin::scenario::scenario_cell_test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr std::string_view kText = R"(name: pair
seed: 7
objects:
  - {name: cube, shape: box, size: [50 mm, 50 mm, 50 mm], mass: 0.1 kg, on: ground, position: [0.5 m, 0 m, 0 m],
     spread: {position: [10 mm, 10 mm, 0 mm]}}
robots:
  right:
    robot: {hand: none, pose: {position: [0 m, -0.8 m, 0.1 m], yaw: 90 deg}}
    plant: {noise: {q: 0.001 deg}}
    motion: &motion
      trajectory:
        unit: rad
        duration: 4 s
        waypoints:
          - {q: [0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]}
          - {q: [0.3, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]}
  left:
    seed: 3
    link: {command_loss: 1 %}
    onboard: {abort_after_lost: 10}
    motion: *motion
render: {fps: 50 Hz}
)";

Cell Read(const std::string& text) {
  return ParseCell(text, "cell.yaml");
}

std::string With(std::string_view from, std::string_view to) {
  std::string text(kText);
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

std::string MessageOf(const std::string& text) {
  try {
    (void)Read(text);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

TEST(ScenarioCellTest, GivesEachRobotAScenarioOfItsOwn) {
  const Cell cell = Read(std::string(kText));
  ASSERT_EQ(cell.robots.size(), 2U);
  const CellRobot& left = cell.robots[0];
  const CellRobot& right = cell.robots[1];
  EXPECT_EQ(left.name, "left");
  EXPECT_EQ(right.name, "right");
  EXPECT_EQ(left.scenario.name, "pair_left");
  EXPECT_EQ(left.scenario.onboard.abort_after_lost, 10U);
  EXPECT_EQ(right.scenario.onboard.abort_after_lost, OnboardSection().abort_after_lost);
  EXPECT_EQ(right.scenario.robot.hand, plant::HandKind::kNone);
  EXPECT_EQ(right.scenario.robot.pose.position, (Vector3{0, -0.8, 0.1}));
  EXPECT_GT(right.scenario.plant.noise_q, 0);
  EXPECT_EQ(right.where, "cell.yaml:7");
  EXPECT_EQ(left.scenario.motion.waypoints.size(), 2U);
}

TEST(ScenarioCellTest, SeedsRobotsByTheirNames) {
  const Cell cell = Read(std::string(kText));
  EXPECT_EQ(cell.robots[0].scenario.seed, 3U);
  EXPECT_EQ(cell.robots[1].scenario.seed, SeedOf(7, "right"));
  EXPECT_NE(SeedOf(7, "right"), SeedOf(7, "left"));
  EXPECT_NE(SeedOf(7, "right"), SeedOf(8, "right"));
  // Another robot before it in the order of names changes nothing.
  const Cell more = Read(With("  left:\n    seed: 3",
                              "  another:\n    robot: {pose: {position: [0 m, 3 m, 0 m]}}\n"
                              "    motion: *motion\n  left:\n    seed: 3"));
  ASSERT_EQ(more.robots.size(), 3U);
  EXPECT_EQ(more.robots[2].scenario, cell.robots[1].scenario);
}

TEST(ScenarioCellTest, NeedsNoMotionOfARobotThatIsServed) {
  const std::string text =
      "name: one\nrobots:\n  still: {robot: {q_start: {unit: rad, values: [0, -0.7854, 0, -2.3562, "
      "0, 1.5708, 0.7854]}}}\n";
  const Cell cell = ParseServedCell(text, "cell.yaml", 8);
  EXPECT_EQ(cell.common.seed, 8U);
  EXPECT_EQ(cell.robots[0].scenario.seed, SeedOf(8, "still"));
  EXPECT_THAT(MessageOf(text), HasSubstr("motion"));
}

TEST(ScenarioCellTest, DrawsTheObjectsOnceForAll) {
  const Cell cell = Read(std::string(kText));
  const auto& left = cell.robots[0].scenario;
  const auto& right = cell.robots[1].scenario;
  EXPECT_EQ(left.objects, right.objects);
  EXPECT_EQ(ObjectsOf(left.objects, left.seed), ObjectsOf(cell.common.objects, cell.common.seed));
  EXPECT_NE(left.objects, cell.common.objects);
}

TEST(ScenarioCellTest, WritesWhatItReads) {
  const Cell cell = Read(std::string(kText));
  const Cell again = ParseCell(ToYaml(cell), "again.yaml");
  EXPECT_EQ(again.common, cell.common);
  ASSERT_EQ(again.robots.size(), cell.robots.size());
  for (std::size_t i = 0; i < cell.robots.size(); ++i) {
    EXPECT_EQ(again.robots[i].name, cell.robots[i].name);
    EXPECT_EQ(again.robots[i].scenario, cell.robots[i].scenario);
    // One of them alone is a scenario, too.
    const Scenario& scenario = cell.robots[i].scenario;
    EXPECT_EQ(Parse(ToYaml(scenario), "one.yaml"), scenario);
  }
}

TEST(ScenarioCellTest, TakesAnApplicationInPlaceOfAMotion) {
  const std::string text = With(
      "    motion: *motion\n",
      "    robot: {q_start: {unit: rad, values: [0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]}}\n"
      "    application: {type: wave, parameters: {to: right}}\n");
  const Cell cell = Read(text);
  ASSERT_TRUE(cell.robots[0].scenario.application);
  EXPECT_EQ(cell.robots[0].scenario.application->type, "wave");
  EXPECT_FALSE(cell.robots[1].scenario.application);
  const Cell again = ParseCell(ToYaml(cell), "again.yaml");
  EXPECT_EQ(again.robots[0].scenario, cell.robots[0].scenario);
  EXPECT_THAT(MessageOf(With("render:", "application: {type: wave}\nrender:")),
              HasSubstr("cell.yaml:22: application: beside robots"));
}

TEST(ScenarioCellTest, RefusesWhatIsWrongWhereItStands) {
  EXPECT_THAT(MessageOf(With("  left:\n", "  right:\n")),
              HasSubstr("cell.yaml:17: robots.right: given twice"));
  EXPECT_THAT(MessageOf(With("render:", "robot: {hand: none}\nrender:")),
              HasSubstr("cell.yaml:22: robot: beside robots"));
  EXPECT_THAT(MessageOf(With("render:", "base: {}\nrender:")),
              HasSubstr("cell.yaml:22: base: is of one robot"));
  EXPECT_THAT(MessageOf(With("    seed: 3\n", "    sead: 3\n")),
              HasSubstr("cell.yaml:18: robots.left: unknown key \"sead\""));
  EXPECT_THAT(MessageOf(With("hand: none, ", "hands: none, ")),
              HasSubstr("cell.yaml:8: robots.right.robot: unknown key"));
  EXPECT_THAT(MessageOf(With("loss: 1 %", "loss: 1")),
              HasSubstr("cell.yaml:19: robots.left.link.command_loss"));
  EXPECT_THAT(MessageOf(With("-0.8 m", "-0.1 m")),
              HasSubstr("cell.yaml:7: robots.right: its base stands 0.100 m from that of left"));
  EXPECT_THAT(MessageOf(With("hand: none, ", "clock_drift: 5 ppm, ")),
              HasSubstr("robots.right: robot.clock_drift"));
  EXPECT_THAT(MessageOf(With("plant: {", "plant: {kind: ideal, ")),
              HasSubstr("robots.right: plant.kind"));
  EXPECT_THAT(MessageOf(With("plant: {", "plant: {base_tilt: {roll: 1 deg}, ")),
              HasSubstr("plant.base_tilt"));
  EXPECT_THAT(MessageOf(With("  left:\n", "  le.ft:\n")),
              HasSubstr("robots.le.ft: the name of a robot"));
  EXPECT_THAT(MessageOf(With("  left:\n", "  plots:\n")), HasSubstr("a folder of results"));
  EXPECT_THAT(MessageOf("name: none\nrobots: {}\n"), HasSubstr("cell.yaml:2: robots: is empty"));
  EXPECT_THAT(MessageOf(With("    motion: *motion\n", "")),
              HasSubstr("robots.left: key \"motion\" is missing"));
}

TEST(ScenarioCellTest, IsRefusedWhereOneRobotIsWanted) {
  try {
    (void)Parse(std::string(kText), "cell.yaml");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("cell.yaml:6: robots: several robots"));
  }
}

}  // namespace
}  // namespace twin::scenario::scenario_cell_test
