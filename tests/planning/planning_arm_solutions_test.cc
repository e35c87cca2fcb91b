#include "twin/planning/arm_solutions.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "planning/planning_fixture.h"
#include "twin/model/arm_model.h"

namespace twin::planning::planning_arm_solutions_test {
namespace {

Transform FlangeAt(const JointVector& q) {
  return model::ArmModel::Panda().Pose(model::Frame::kFlange, q);
}

double LargestDifference(const Transform& a, const Transform& b) {
  double largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, std::abs(a[i] - b[i]));
  return largest;
}

/// Largest difference of angles, whole turns apart.
double Turned(const JointVector& a, const JointVector& b) {
  double largest = 0;
  for (std::size_t i = 0; i < kJoints; ++i) {
    largest = std::max(largest, std::abs(std::remainder(a[i] - b[i], 2 * std::numbers::pi)));
  }
  return largest;
}

TEST(ArmSolutionsTest, EverySolutionReachesThePose) {
  std::size_t count = 0;
  for (std::uint64_t n = 0; n < 2000; ++n) {
    const Transform O_T_F = FlangeAt(Drawn(1, n));
    const ArmSolutions solutions(O_T_F, Drawn(2, n)[6]);
    for (const JointVector& q : solutions.all()) {
      ASSERT_LT(LargestDifference(FlangeAt(q), O_T_F), 1e-8) << n;
    }
    count += solutions.all().size();
  }
  EXPECT_GT(count, 4000);
}

TEST(ArmSolutionsTest, TheConfigurationThePoseWasMadeOfIsAmongThem) {
  for (std::uint64_t n = 0; n < 2000; ++n) {
    const JointVector q = Drawn(3, n);
    const ArmSolutions solutions(FlangeAt(q), q[6]);
    double nearest = 10;
    for (const JointVector& found : solutions.all()) nearest = std::min(nearest, Turned(found, q));
    ASSERT_LT(nearest, 1e-5) << n;  // near a singular pose rounding grows to its root
  }
}

TEST(ArmSolutionsTest, FindsTheReadyPoseAsItIs) {
  const ArmSolutions solutions(FlangeAt(kReady), kReady[6]);
  double nearest = 10;
  for (const JointVector& q : solutions.all()) {
    double largest = 0;
    for (std::size_t i = 0; i < kJoints; ++i) {
      largest = std::max(largest, std::abs(q[i] - kReady[i]));
    }
    nearest = std::min(nearest, largest);
  }
  EXPECT_LT(nearest, 1e-12);
}

TEST(ArmSolutionsTest, AnUprightUpperArmTakesTheGivenFirstJoint) {
  const JointVector q{0.4, 0, 0.3, -1.5, 0.2, 1.7, 0.5};
  const ArmSolutions solutions(FlangeAt(q), q[6], q[0]);
  EXPECT_TRUE(std::any_of(solutions.all().begin(), solutions.all().end(),
                          [&](const JointVector& found) { return Turned(found, q) < 1e-7; }));
}

TEST(ArmSolutionsTest, OutOfReachThereIsNone) {
  Transform O_T_F = kIdentityTransform;
  O_T_F[12] = 1.5;
  EXPECT_TRUE(ArmSolutions(O_T_F, 0).all().empty());
  O_T_F[12] = 0.05;  // and too near to the shoulder
  O_T_F[14] = 0.45;
  EXPECT_TRUE(ArmSolutions(O_T_F, 0).all().empty());
}

}  // namespace
}  // namespace twin::planning::planning_arm_solutions_test
