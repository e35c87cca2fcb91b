#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "twin/core/error.h"
#include "twin/scenario/scenario.h"

namespace twin::scenario::scenario_limits_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

std::string With(const std::string& limits) {
  return R"(name: here
motion:
  trajectory:
    unit: rad
    waypoints:
      - {q: [0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]}
      - {q: [0.1, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]}
limits:
)" + limits;
}

std::string ErrorOf(const std::string& limits) {
  try {
    static_cast<void>(Parse(With(limits), "s.yaml"));
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(LimitsSectionTest, ReadsEveryKey) {
  const Scenario s = Parse(With(R"(
  regions:
    - {name: table edge, what: [end_effector, elbow], keep: inside, box: {min: [-100 mm, -0.5 m, 0 m], max: [0.8 m, 0.5 m, 1 m]}}
    - {name: wall, keep: outside, half_space: {normal: [0, -1, 0], offset: 0.4 m}}
  speed: {joints: 0.5 rad/s, end_effector: 0.25 m/s, rotation: 30 deg/s}
  force: 40 N
  torque: {unit: Nm, values: [20, 20, 20, 20, 10, 10, 10]}
)"),
                           "s.yaml");
  using enum model::LimitedPart;
  ASSERT_EQ(s.limits.regions.size(), 2u);
  const model::LimitRegion table{
      "table edge", {kEndEffector, kElbow}, true, model::LimitBox{{-0.1, -0.5, 0}, {0.8, 0.5, 1}}};
  const model::LimitRegion wall{
      "wall", {kEndEffector, kElbow, kHand}, false, model::HalfSpace{{0, -1, 0}, 0.4}};
  EXPECT_EQ(s.limits.regions[0], table);
  EXPECT_EQ(s.limits.regions[1], wall);
  EXPECT_EQ(s.limits.dq_max, (JointVector{0.5, 0.5, 0.5, 0.5, 0.5, 0.5, 0.5}));
  EXPECT_EQ(s.limits.v_max, 0.25);
  EXPECT_NEAR(s.limits.w_max.value(), 0.5235987755982988, 1e-12);
  EXPECT_EQ(s.limits.force_max, 40);
  EXPECT_EQ(s.limits.tau_max, (JointVector{20, 20, 20, 20, 10, 10, 10}));
  EXPECT_EQ(Parse(ToYaml(s), "again.yaml"), s);
}

TEST(LimitsSectionTest, ASectionWithoutLimitsIsNotWritten) {
  const Scenario s = Parse(With("  {}"), "s.yaml");
  EXPECT_TRUE(s.limits.empty());
  EXPECT_THAT(ToYaml(s), ::testing::Not(HasSubstr("limits:")));
}

TEST(LimitsSectionTest, SaysWhatIsWrongAndWhere) {
  EXPECT_THAT(ErrorOf("  regions: [{name: a, keep: inside, box: {min: [0 m, 0 m, 0 m], max: [1 m, "
                      "0 m, 1 m]}}]"),
              AllOf(HasSubstr("s.yaml:8: limits: "), HasSubstr("region \"a\": its box is empty")));
  EXPECT_THAT(ErrorOf("  regions: [{name: a, keep: inside}]"), HasSubstr("box or half_space"));
  EXPECT_THAT(ErrorOf("  regions: [{name: a, keep: inside, what: [foot], half_space: {normal: [0, "
                      "0, 1], offset: 1 m}}]"),
              HasSubstr("end_effector"));
  EXPECT_THAT(ErrorOf("  force: 40"), HasSubstr("limits.force"));
  EXPECT_THAT(ErrorOf("  speed: {joints: 0 rad/s}"), HasSubstr("speed.joints is 0"));
  EXPECT_THAT(ErrorOf("  spede: {}"), HasSubstr("did you mean \"speed\""));
}

}  // namespace
}  // namespace twin::scenario::scenario_limits_test
