#include "twin/planning/pose_goal.h"

#include <algorithm>
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "planning/planning_fixture.h"
#include "twin/core/error.h"
#include "twin/model/arm_model.h"

namespace twin::planning::planning_pose_goal_test {
namespace {

using testing::HasSubstr;
using Found = std::variant<std::vector<JointVector>, NoPose>;

Transform FlangeAt(const JointVector& q) {
  return model::ArmModel::Panda().Pose(model::Frame::kFlange, q);
}

double Distance(const JointVector& a, const JointVector& b) {
  double sum = 0;
  for (std::size_t i = 0; i < kJoints; ++i) sum += std::pow(a[i] - b[i], 2);
  return std::sqrt(sum);
}

class PoseGoalTest : public testing::Test {
 protected:
  Found At(const Transform& O_T_F, const PoseGoalOptions& options) {
    return ConfigurationsAt(O_T_F, limits_, world_, options);
  }
  std::vector<JointVector> Solutions(const Transform& O_T_F, const PoseGoalOptions& options) {
    const Found found = At(O_T_F, options);
    if (const auto* none = std::get_if<NoPose>(&found)) {
      ADD_FAILURE() << none->text;
      return {};
    }
    return std::get<std::vector<JointVector>>(found);
  }
  NoPose Refusal(const Transform& O_T_F, const PoseGoalOptions& options) {
    const Found found = At(O_T_F, options);
    if (const auto* none = std::get_if<NoPose>(&found)) return *none;
    ADD_FAILURE() << "there is a solution";
    return {};
  }

  CollisionWorld world_{Options("clutter.xml")};
  const JointLimits limits_ = test::PandaLimits();
};

TEST_F(PoseGoalTest, FindsWhereTheArmAlreadyIs) {
  const auto found = Solutions(FlangeAt(kReady), {.near = kReady});
  ASSERT_FALSE(found.empty());
  EXPECT_LT(Distance(found.front(), kReady), 1e-9);
}

TEST_F(PoseGoalTest, SolutionsReachThePoseInsideTheLimitsFreeAndNearestFirst) {
  const Transform O_T_F = Down(0.45, 0.1, 0.5);
  const PoseGoalOptions options{.near = kReady, .clearance = 0.02, .limit_margin = 0.1};
  const auto found = Solutions(O_T_F, options);
  ASSERT_GT(found.size(), 3);
  double last = 0;
  for (const JointVector& q : found) {
    const Transform reached = FlangeAt(q);
    for (std::size_t i = 0; i < 16; ++i) EXPECT_NEAR(reached[i], O_T_F[i], 1e-9);
    for (std::size_t i = 0; i < kJoints; ++i) {
      EXPECT_GE(q[i], limits_.q_min[i] + options.limit_margin);
      EXPECT_LE(q[i], limits_.q_max[i] - options.limit_margin);
    }
    EXPECT_TRUE(world_.IsFree(q, options.clearance));
    EXPECT_GE(Distance(q, kReady), last);
    last = Distance(q, kReady);
  }
}

TEST_F(PoseGoalTest, UsesTheRedundancy) {
  const auto found = Solutions(Down(0.45, 0.1, 0.5), {.near = kReady, .most = 1000});
  const auto [low, high] =
      std::minmax_element(found.begin(), found.end(),
                          [](const JointVector& a, const JointVector& b) { return a[6] < b[6]; });
  EXPECT_GT((*high)[6] - (*low)[6], 1.9);  // of joint 7's 5.8 rad
  for (std::size_t i = 0; i < found.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) EXPECT_GE(Distance(found[i], found[k]), 0.2);
  }
}

TEST_F(PoseGoalTest, FindsAWayToThePoseOfEveryFreeConfiguration) {
  int tried = 0;
  for (std::uint64_t n = 0; n < 60; ++n) {
    const JointVector q = Drawn(5, n);
    if (!world_.IsFree(q, 0.02)) continue;
    JointVector near = kReady;
    near[6] = q[6];  // a step of joint 7 meets it
    EXPECT_FALSE(Solutions(FlangeAt(q), {.near = near, .limit_margin = 0}).empty()) << n;
    ++tried;
  }
  EXPECT_GT(tried, 20);
}

TEST_F(PoseGoalTest, TellsThatAPoseIsOutOfReach) {
  const NoPose none = Refusal(Down(0.9, 0, 0.5), {.near = kReady});
  EXPECT_EQ(none.reason, NoPoseReason::kOutOfReach);
  EXPECT_THAT(none.text, HasSubstr("(0.900, 0.000, 0.500) m"));
}

TEST_F(PoseGoalTest, TellsWhichJointTheLimitsStop) {
  // Fingers up, right above the base: the wrist would have to fold back on the upper arm.
  Transform up = kIdentityTransform;
  up[12] = 0.1;
  up[14] = 0.62;
  const NoPose none = Refusal(up, {.near = kReady});
  EXPECT_EQ(none.reason, NoPoseReason::kLimits);
  EXPECT_THAT(none.text, HasSubstr("needs joint "));
}

TEST_F(PoseGoalTest, TellsWhichBodiesAreInTheWay) {
  const NoPose none = Refusal(Down(0.55, 0.1, 0.25), {.near = kReady});
  EXPECT_EQ(none.reason, NoPoseReason::kCollision);
  EXPECT_THAT(none.text, HasSubstr("and table overlap"));
}

TEST_F(PoseGoalTest, LooksNoFurtherThanItsChecks) {
  const std::uint64_t before = world_.checks();
  const NoPose none = Refusal(Down(0.55, 0.1, 0.25), {.near = kReady, .most_checks = 5});
  EXPECT_EQ(none.reason, NoPoseReason::kCollision);
  EXPECT_EQ(world_.checks() - before, 6);  // and one to tell what is in the way
}

TEST_F(PoseGoalTest, RefusesAnOptionOutOfRange) {
  EXPECT_THAT(MessageOf<InputError>([&] {
                static_cast<void>(At(Down(0.5, 0, 0.5), {.near = kReady, .q7_step = 0}));
              }),
              HasSubstr("q7_step"));
  EXPECT_THAT(
      MessageOf<InputError>([&] { static_cast<void>(At(Down(0.5, 0, 0.5), {.near = {NAN}})); }),
      HasSubstr("near"));
  JointLimits narrow = limits_;
  narrow.q_min[3] = narrow.q_max[3] - 0.01;
  EXPECT_THAT(
      MessageOf<InputError>([&] {
        static_cast<void>(ConfigurationsAt(Down(0.5, 0, 0.5), narrow, world_, {.near = kReady}));
      }),
      HasSubstr("leaves nothing of joint 4's range"));
}

}  // namespace
}  // namespace twin::planning::planning_pose_goal_test
