#include "twin/scenario/scenario.h"

#include <filesystem>
#include <fstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/temporary_folder.h"
#include "twin/core/error.h"

namespace twin::scenario::scenario_lab_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

const std::filesystem::path kModels = std::filesystem::path(TWIN_SOURCE_DIR) / "models";

Scenario Here(const std::string& more = "") {
  return Parse(R"(name: here
link: {d_INT: 50 us, command_loss: 1 %}
controller: {rate: 500 Hz, cost: 10 us}
)" + more + R"(
motion:
  trajectory:
    unit: rad
    waypoints:
      - {q: [0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]}
      - {q: [0.1, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]}
)",
               "here.yaml");
}

class LabTest : public ::testing::Test {
 protected:
  /// The scenario at a lab of this text.
  Scenario At(const std::string& lab, Scenario scenario = Here()) {
    const std::filesystem::path file = folder_.path() / "lab.yaml";
    std::ofstream(file) << lab;
    ApplyLab(file, scenario);
    return scenario;
  }
  std::string ErrorOf(const std::string& lab, const Scenario& scenario = Here()) {
    try {
      static_cast<void>(At(lab, scenario));
    } catch (const InputError& error) {
      return error.what();
    }
    return "accepted";
  }

  twin::test::TemporaryFolder folder_;
};

TEST_F(LabTest, WinsWhereBothSaySomethingAndLeavesTheRest) {
  const Scenario there = At(R"(
description: somewhere
plant: {mass_scale: 0.95, base_tilt: {roll: 1 deg}, friction: breakaway}
link: {command_loss: 0.5 %, state_delay: 80 us}
controller: {cost: 20 us}
)");
  Scenario expected = Here();
  expected.plant.mass_scale = 0.95;
  expected.plant.base_tilt.roll = 1 * 3.14159265358979323846 / 180;
  expected.plant.friction = plant::FrictionProfile::kBreakaway;
  expected.link.command.loss = {IndependentLoss{0.5}};
  expected.link.state.delay = {faults::ConstantDelay{std::chrono::microseconds(80)}};
  expected.controller.cost = {faults::ConstantDelay{std::chrono::microseconds(20)}};
  EXPECT_DOUBLE_EQ(there.plant.base_tilt.roll, expected.plant.base_tilt.roll);
  expected.plant.base_tilt = there.plant.base_tilt;
  EXPECT_EQ(there, expected);
}

TEST_F(LabTest, WhatCameOfItStandsInTheScenarioThatIsWritten) {
  const Scenario there =
      At("plant: {mass_scale: 1.05, base_tilt: {roll: 0.01 rad, pitch: -2 deg}}");
  EXPECT_EQ(Parse(ToYaml(there), "again.yaml"), there);
}

TEST_F(LabTest, APlantAsItAlwaysWasIsWrittenAsItAlwaysWas) {
  EXPECT_THAT(ToYaml(Here()), AllOf(Not(HasSubstr("mass_scale")), Not(HasSubstr("base_tilt"))));
}

TEST_F(LabTest, SaysWhatALabMayNotHave) {
  EXPECT_THAT(ErrorOf("plant: {}\nrobot: {hand: none}"),
              AllOf(HasSubstr("lab.yaml:2: robot: "), HasSubstr("it is the scenario's")));
  EXPECT_THAT(ErrorOf("seed: 3"),
              HasSubstr("a lab has description, plant, link, load, controller, limits"));
  EXPECT_THAT(ErrorOf("plnt: {mass_scale: 1}"), HasSubstr("did you mean \"plant\""));
  EXPECT_THAT(ErrorOf("controller: {type: compliance}"), HasSubstr("lab.yaml:1: controller"));
}

TEST_F(LabTest, SaysWhichValueIsOutOfRange) {
  EXPECT_THAT(ErrorOf("plant: {mass_scale: 3}"), HasSubstr("plant.mass_scale"));
  EXPECT_THAT(ErrorOf("plant: {base_tilt: {pitch: 30 deg}}"), HasSubstr("plant.base_tilt.pitch"));
  EXPECT_THAT(ErrorOf("plant: {base_tilt: {yaw: 1 deg}}"), HasSubstr("yaw"));
}

TEST_F(LabTest, DoesNotGoWithAnIdealPlantThatHasNoWeight) {
  EXPECT_THAT(ErrorOf("plant: {mass_scale: 1.05}", Here("plant: {kind: ideal}")),
              AllOf(HasSubstr("with scenario here"), HasSubstr("leave mass_scale, base_tilt")));
}

TEST_F(LabTest, AddsLimitsToThoseOfTheScenario) {
  const std::string wall =
      "{name: wall, keep: inside, half_space: {normal: [1, 0, 0], offset: 1 m}}";
  const Scenario here = Here("limits: {regions: [" + wall +
                             "], speed: {joints: 1 rad/s, end_effector: 0.2 m/s}, force: 20 N}");
  const Scenario there = At(R"(
limits:
  regions: [{name: floor, keep: inside, half_space: {normal: [0, 0, -1], offset: 0 m}}]
  speed: {joints: 0.5 rad/s, end_effector: 0.5 m/s}
)",
                            here);
  ASSERT_EQ(there.limits.regions.size(), 2u);
  EXPECT_EQ(there.limits.regions[0].name, "wall");
  EXPECT_EQ(there.limits.regions[1].name, "floor");
  EXPECT_EQ(there.limits.dq_max.value()[6], 0.5);
  EXPECT_EQ(there.limits.v_max, 0.2);
  EXPECT_EQ(there.limits.force_max, 20);
  EXPECT_EQ(Parse(ToYaml(there), "again.yaml"), there);
  EXPECT_THAT(ErrorOf("limits: {regions: [" + wall + "]}", here),
              HasSubstr("region \"wall\": another region has this name; rename one of them"));
}

TEST_F(LabTest, IsFoundByNameOrAsAFile) {
  EXPECT_EQ(FindLab("a", kModels), kModels / "labs" / "a.yaml");
  const std::string file = (kModels / "labs" / "b.yaml").string();
  EXPECT_EQ(FindLab(file, "/nowhere"), file);
  try {
    static_cast<void>(FindLab("c", kModels));
    ADD_FAILURE() << "there is no lab c";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("one of a, b"));
  }
}

TEST_F(LabTest, TheTwoThatComeWithItDiffer) {
  Scenario a = Here();
  Scenario b = Here();
  ApplyLab(FindLab("a", kModels), a);
  ApplyLab(FindLab("b", kModels), b);
  EXPECT_GT(a.plant.mass_scale, 1);
  EXPECT_LT(b.plant.mass_scale, 1);
  EXPECT_NE(a.plant.friction, b.plant.friction);
  EXPECT_NE(a.link, b.link);
}

}  // namespace
}  // namespace twin::scenario::scenario_lab_test
