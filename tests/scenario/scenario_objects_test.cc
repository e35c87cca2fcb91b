#include "twin/scenario/objects.h"

#include <cmath>
#include <numbers>
#include <set>
#include <string>
#include <string_view>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenario/scenario_examples.h"
#include "twin/core/error.h"
#include "twin/scenario/scenario.h"

namespace twin::scenario::scenario_objects_test {
namespace {

using testing::HasSubstr;

constexpr double kDegree = std::numbers::pi / 180;

constexpr std::string_view kText = R"(name: things
robot:
  q_start: {unit: deg, values: [0, -45, 0, -135, 0, 90, 45]}
objects:
  - {name: stand, shape: box, size: [0.3 m, 0.4 m, 0.2 m], on: ground, position: [0.5 m, 0.1 m, 0 m], rpy: [0 deg, 20 deg, 0 deg],
     spread: {size: [0 m, 0 m, 20 mm]}}
  - name: can
    shape: cylinder
    size: [50 mm, 50 mm, 80 mm]
    mass: 0.2 kg
    friction: 0.8
    on: stand
    position: [10 mm, -20 mm, 0 mm]
    rpy: [0 deg, 0 deg, 30 deg]
    colour: [0.1, 0.2, 0.3]
    spread: {size: [2 mm, 0 mm, 5 mm], mass: 50 g, position: [5 mm, 5 mm, 0 mm], rpy: [0 deg, 0 deg, 40 deg], friction: 0.1}
  - {name: ball, shape: sphere, size: [60 mm, 60 mm, 60 mm], mass: 100 g, position: [0 m, 0.5 m, 1 m]}
application: {type: whatever}
)";

/// The message of the error that comes of changing the text in one place.
std::string Spoiled(std::string_view from, std::string_view to) {
  return test::Spoiled(kText, from, to);
}

std::vector<plant::SceneObject> OfSeed(std::uint64_t seed) {
  return ObjectsOf(Parse(std::string(kText), "s.yaml").objects, seed);
}

TEST(ScenarioObjectsTest, AreReadAndWritten) {
  const Scenario scenario = Parse(std::string(kText), "s.yaml");
  ASSERT_EQ(scenario.objects.size(), 3U);
  EXPECT_EQ(scenario.objects[0].where, "s.yaml:5");
  EXPECT_FALSE(scenario.objects[0].mass.has_value());
  EXPECT_EQ(scenario.objects[1].mass, 0.2);
  EXPECT_EQ(scenario.objects[1].spread.mass, 0.05);
  EXPECT_EQ(scenario.objects[2].shape, plant::ObjectShape::kSphere);
  EXPECT_EQ(Parse(ToYaml(scenario), "t.yaml"), scenario);
  EXPECT_EQ(ToYaml(Parse(ToYaml(scenario), "t.yaml")), ToYaml(scenario));
}

TEST(ScenarioObjectsTest, StandOnWhatIsBelowThem) {
  ObjectSection stand{.name = "stand", .size = {0.3, 0.4, 0.2}, .on = "ground"};
  stand.pose = {{0.5, 0.1, 0}, {0, 20 * kDegree, 0}};
  ObjectSection can{
      .name = "can", .shape = plant::ObjectShape::kCylinder, .size = {0.05, 0.05, 0.08}};
  can.mass = 0.2;
  can.on = "stand";
  can.pose = {{0.01, -0.02, 0}, {0, 0, 0.5}};
  const auto objects = ObjectsOf(std::vector{stand, can}, 1);
  const double s = std::sin(20 * kDegree);
  const double c = std::cos(20 * kDegree);
  EXPECT_NEAR(objects[0].X_WB[14], (0.3 * s + 0.2 * c) / 2, 1e-12) << "its edge is on the ground";
  // Half of the stand and half of the can along the stand's z axis, and a little along its x and y.
  EXPECT_NEAR(objects[1].X_WB[12], 0.5 + 0.14 * s + 0.01 * c, 1e-12);
  EXPECT_NEAR(objects[1].X_WB[13], 0.1 - 0.02, 1e-12);
  EXPECT_NEAR(objects[1].X_WB[14], objects[0].X_WB[14] + 0.14 * c - 0.01 * s, 1e-12);
  EXPECT_NEAR(objects[1].X_WB[10], c, 1e-12) << "they lean alike";
}

TEST(ScenarioObjectsTest, LieAsHighAsTheyAreTurned) {
  const plant::SceneObject box{.name = "box", .size = {0.1, 0.2, 0.3}};
  const plant::SceneObject can{
      .name = "can", .shape = plant::ObjectShape::kCylinder, .size = {0.1, 0.1, 0.3}};
  const auto turned = [](double roll) { return FramePose{{}, {roll, 0, 0}}.Matrix(); };
  EXPECT_NEAR(HalfHeight(box, turned(0)), 0.15, 1e-12);
  EXPECT_NEAR(HalfHeight(box, turned(90 * kDegree)), 0.1, 1e-12);
  EXPECT_NEAR(HalfHeight(box, turned(45 * kDegree)), 0.25 / std::sqrt(2), 1e-12);
  EXPECT_NEAR(HalfHeight(can, turned(0)), 0.15, 1e-12);
  EXPECT_NEAR(HalfHeight(can, turned(90 * kDegree)), 0.05, 1e-12);
}

TEST(ScenarioObjectsTest, AreDrawnFromTheSeedInsideTheirSpread) {
  std::set<double> masses;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    const auto objects = OfSeed(seed);
    EXPECT_EQ(objects, OfSeed(seed));
    EXPECT_NEAR(objects[0].size[2], 0.2, 0.02);
    EXPECT_EQ(objects[0].size[0], 0.3);
    EXPECT_NEAR(objects[1].size[0], 0.05, 0.002);
    EXPECT_EQ(objects[1].size[0], objects[1].size[1]) << "a can is round";
    EXPECT_NEAR(objects[1].size[2], 0.08, 0.005);
    EXPECT_NEAR(*objects[1].mass, 0.2, 0.05);
    EXPECT_NEAR(objects[1].friction, 0.8, 0.1);
    EXPECT_EQ(objects[2], OfSeed(1)[2]) << "nothing of the ball is spread";
    masses.insert(*objects[1].mass);
  }
  EXPECT_EQ(masses.size(), 100U);
  EXPECT_GT(*masses.rbegin() - *masses.begin(), 0.08) << "all of the range is used";
}

// What one value is spread by changes no other one.
TEST(ScenarioObjectsTest, DrawsEveryValueByItself) {
  std::vector<ObjectSection> objects = Parse(std::string(kText), "s.yaml").objects;
  const auto before = ObjectsOf(objects, 3);
  objects[1].spread.size = {};
  const auto after = ObjectsOf(objects, 3);
  EXPECT_EQ(before[1].mass, after[1].mass);
  EXPECT_EQ(before[1].X_WB[0], after[1].X_WB[0]);
}

TEST(ScenarioObjectsTest, AreRefusedWithTheirPlace) {
  EXPECT_THAT(Spoiled("on: stand", "on: ball"), HasSubstr("s.yaml:7: objects: can: on: \"ball\""));
  EXPECT_THAT(Spoiled("name: ball", "name: can"), HasSubstr("two of that name"));
  EXPECT_THAT(Spoiled("size: [50 mm, 50 mm", "size: [50 mm, 40 mm"),
              HasSubstr("objects: can: size"));
  EXPECT_THAT(Spoiled("mass: 0.2 kg", "mass: 0.2 m"), HasSubstr("s.yaml:10"));
  EXPECT_THAT(Spoiled("mass: 50 g", "mass: 250 g"), HasSubstr("objects: can: object can: mass"))
      << "of this seed it would be drawn below zero";
  EXPECT_THAT(Spoiled("shape: sphere", "shape: egg"), HasSubstr("s.yaml:17"));
  EXPECT_THAT(Spoiled("{size: [0 m, 0 m, 20 mm]}", "{mass: 1 kg}"),
              HasSubstr("fixed to the world"));
}

}  // namespace
}  // namespace twin::scenario::scenario_objects_test
