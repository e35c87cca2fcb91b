// The controller of a scenario: library, parameters; and motions of poses.

#include <chrono>
#include <filesystem>
#include <numbers>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "run/resolve.h"
#include "scenario/scenario_examples.h"
#include "twin/core/error.h"
#include "twin/model/arm_model.h"
#include "twin/model/transform.h"
#include "twin/scenario/scenario.h"

namespace twin::run::run_controller_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::StartsWith;
using namespace std::chrono_literals;  // NOLINT(google-build-using-namespace): 2s

constexpr double kDegree = std::numbers::pi / 180;

/// What reading `text` complains of.
std::string Complaint(const std::string& text) {
  try {
    (void)scenario::Parse(text, "s.yaml");
  } catch (const InputError& error) {
    return error.what();
  }
  return "(accepted)";
}

std::string Spoiled(const std::string& from, const std::string& to) {
  return Complaint(scenario::test::Replaced(scenario::test::PosesText(), from, to));
}

TEST(ScenarioControllerTest, ReadsLibraryAndParameters) {
  const scenario::ControllerSection controller =
      scenario::Parse(scenario::test::PosesText(), "folder/s.yaml").controller;
  EXPECT_EQ(controller.library, std::filesystem::absolute("folder/build/my_law.so"));
  EXPECT_EQ(controller.type, "my_law");
  const control::Parameters& p = controller.parameters;
  ASSERT_EQ(p.size(), 7u);
  EXPECT_EQ(p[0], (control::Parameter{.key = "reference", .values = {"hold"}}));
  EXPECT_EQ(p[1].key, "stiffness.translation");
  EXPECT_EQ(p[2].values, (std::vector<std::string>{"10 Nm/rad", "20 Nm/rad", "30 Nm/rad"}));
  EXPECT_TRUE(p[2].is_list);
  EXPECT_EQ(p[3], (control::Parameter{.key = "q0.unit", .values = {"deg"}}));
  EXPECT_EQ(p[4].values.size(), 7u);
  EXPECT_EQ(p[4].where, "folder/s.yaml:8");
  EXPECT_EQ(p[5].key, "deep.er.still");
  EXPECT_TRUE(p[6].values.empty());
}

TEST(ScenarioControllerTest, ReadsPoses) {
  const scenario::MotionSection motion =
      scenario::Parse(scenario::test::PosesText(), "s.yaml").motion;
  ASSERT_EQ(motion.waypoints.size(), 1u);
  EXPECT_DOUBLE_EQ(motion.waypoints[0].q[3], -135 * kDegree);
  EXPECT_EQ(motion.timing.jerk_scale, 0.2);
  EXPECT_EQ(motion.timing.acceleration_scale, 0.03) << "gentle by default";
  ASSERT_EQ(motion.poses.size(), 3u);
  EXPECT_EQ(motion.poses[0].by, (Vector3{0, 0.1, 0}));
  EXPECT_EQ(motion.poses[0].at, 2s);
  EXPECT_EQ(motion.poses[1].position, (Vector3{0.4, 0.1, 0.5}));
  EXPECT_DOUBLE_EQ(motion.poses[1].turn[2], 45 * kDegree);
  EXPECT_DOUBLE_EQ(motion.poses[2].rpy.value()[0], std::numbers::pi);
  EXPECT_EQ(motion.poses[2].where, "s.yaml:19");
}

TEST(ScenarioControllerTest, SurvivesTheRoundTrip) {
  const scenario::Scenario scenario = scenario::Parse(scenario::test::PosesText(), "s.yaml");
  const scenario::Scenario again = scenario::Parse(scenario::ToYaml(scenario), "elsewhere/t.yaml");
  EXPECT_EQ(again, scenario);
  scenario::Scenario other = scenario;
  other.controller.parameters[4].values[3] = "-91";
  EXPECT_FALSE(scenario::Parse(scenario::ToYaml(other), "t.yaml") == scenario);
}

TEST(ScenarioControllerTest, RefusesWhatMakesNoSense) {
  EXPECT_THAT(Spoiled("type: my_law", "rate: 1000 Hz"), HasSubstr("\"type\" is missing"));
  EXPECT_THAT(Spoiled("build/my_law.so", "\"\""), HasSubstr("names no file"));
  EXPECT_THAT(Spoiled("reference: hold", "reference: hold\n    reference: path"),
              HasSubstr("given twice"));
  EXPECT_THAT(Spoiled("reference: hold", "a.b: hold"), HasSubstr("letters, digits"));
  EXPECT_THAT(Spoiled("none: []", "none: [[1]]"), StartsWith("s.yaml:10: "));
  EXPECT_THAT(Spoiled("still: true", "still: {}"), HasSubstr("is empty"));
  EXPECT_THAT(Spoiled("  poses:", "  trajectory: t.yaml\n  poses:"), HasSubstr("one of the two"));
  EXPECT_THAT(Spoiled("rpy: [180 deg, 0 deg, 0 deg]",
                      "position: [0 m, 0 m, 0 m], by: [0 m, 0 m, "
                      "0 m]"),
              HasSubstr("one of the two"));
  EXPECT_THAT(Spoiled("100 mm", "100"), HasSubstr("has no unit"));
}

class PosesPlanTest : public ::testing::Test {
 protected:
  PosesPlanTest() {
    backends_.Add("mujoco", [](const backend::Request&) { return backend::Connection(); });
    controllers_.Add("joint_trajectory", [](const control::ControllerRequest&) { return nullptr; });
  }
  [[nodiscard]] Plan PlanOf(const std::string& text) const {
    return MakePlan(scenario::Parse(text, "s.yaml"), {backends_, controllers_}, files_);
  }

  backend::Registry backends_;
  control::ControllerRegistry controllers_;
  const RunFiles files_{std::filesystem::path(TWIN_SOURCE_DIR) / "models", {}, {}, false};
};

TEST_F(PosesPlanTest, MakesEachPoseOfTheOneBefore) {
  const Plan plan = PlanOf(scenario::test::PosesText());
  ASSERT_TRUE(plan.motion.poses.has_value());
  const Transform F_T_EE = model::Multiply(plan.config.onboard.F_T_NE, kIdentityTransform);
  const Transform start =
      model::ArmModel::Panda().Pose(model::Frame::kEndEffector, plan.config.q_start, F_T_EE);
  EXPECT_EQ(plan.motion.poses->start(), start);
  EXPECT_EQ(plan.motion.poses->duration(), 5s);
  const Transform first = plan.motion.poses->Sample(2s).O_T_EE;
  EXPECT_NEAR(first[13], start[13] + 0.1, 1e-12);
  EXPECT_NEAR(first[0], start[0], 1e-12) << "not turned";
  const Transform second = plan.motion.poses->Sample(4s).O_T_EE;
  EXPECT_NEAR(second[12], 0.4, 1e-12);
  // Turned by 45 degrees about the base's z: the x axis of EE by its projection.
  const double c = std::numbers::sqrt2 / 2;
  EXPECT_NEAR(second[0], c * start[0] - c * start[1], 1e-12);
  EXPECT_NEAR(second[1], c * start[0] + c * start[1], 1e-12);
  const Transform goal = plan.motion.poses->goal();
  EXPECT_NEAR(goal[0], 1, 1e-12);
  EXPECT_NEAR(goal[5], -1, 1e-12);
  EXPECT_NEAR(goal[12], 0.4, 1e-12);
}

TEST_F(PosesPlanTest, LetsTheJointPathStandMeanwhile) {
  const Plan plan = PlanOf(scenario::test::PosesText());
  EXPECT_EQ(plan.motion.trajectory.duration(), 5s);
  EXPECT_EQ(plan.motion.trajectory.start(), plan.motion.trajectory.goal());
  EXPECT_EQ(plan.motion.trajectory.Sample(3s).q, plan.config.q_start);
}

TEST_F(PosesPlanTest, NamesTheLineOfAPoseThatIsTooFast) {
  try {
    (void)PlanOf(scenario::test::Replaced(scenario::test::PosesText(), "at: 2 s", "at: 20 ms"));
    ADD_FAILURE() << "accepted";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("s.yaml:17"), HasSubstr("at least")));
  }
}

TEST_F(PosesPlanTest, SlowsDownPosesToo) {
  scenario::Scenario scenario = scenario::Parse(scenario::test::PosesText(), "s.yaml");
  const Plan plan = MakePlan(scenario, {backends_, controllers_}, files_);
  SlowDown(scenario, plan.robot, 0.5);
  EXPECT_EQ(scenario.motion.poses[0].at, 4s);
  EXPECT_EQ(MakeTrajectory(scenario, plan.robot).duration(), 10s);
}

}  // namespace
}  // namespace twin::run::run_controller_test
