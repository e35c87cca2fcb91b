#include "twin/onboard/cartesian_reference.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "twin/model/transform.h"

namespace twin::onboard::onboard_cartesian_reference_test {
namespace {

constexpr double kT = 1e-3;

Transform PoseAt(double x, double angle, const Eigen::Vector3d& axis = Eigen::Vector3d::UnitZ()) {
  return model::Pose(Eigen::Quaterniond(Eigen::AngleAxisd(angle, axis)), {x, 0.2, 0.4});
}

TEST(CartesianReferenceTest, FormsBackwardDifferencesOfPoses) {
  // x(t) = t^3, turned about z by t^2.
  const auto x = [](int k) { return std::pow(k * kT, 3); };
  const auto turn = [](int k) { return std::pow(k * kT, 2); };
  auto reference = CartesianReference::Rest(PoseAt(x(100), turn(100)), {0, -1});
  CartesianReference before;
  for (int k = 101; k <= 110; ++k) {
    before = reference;
    reference = reference.AfterPose(PoseAt(x(k), turn(k)));
  }
  const double dp = (x(110) - x(109)) / kT;
  const double ddp = (dp - (x(109) - x(108)) / kT) / kT;
  EXPECT_NEAR(reference.O_dP_EE_c[0], dp, 1e-12);
  EXPECT_NEAR(reference.O_ddP_EE_c[0], ddp, 1e-9);
  EXPECT_NEAR(reference.O_dddP_EE_c[0], 6, 1e-5);
  EXPECT_NEAR(reference.O_dP_EE_c[5], (turn(110) - turn(109)) / kT, 1e-12);
  EXPECT_NEAR(reference.O_ddP_EE_c[5], 2, 1e-8);
  EXPECT_NEAR(reference.O_dddP_EE_c[5], 0, 1e-5);
  EXPECT_NEAR(reference.O_dP_EE_c[3], 0, 1e-12);
  EXPECT_EQ(reference.O_T_EE_c, PoseAt(x(110), turn(110)));
  EXPECT_NEAR(before.O_ddP_EE_c[0], reference.O_ddP_EE_c[0] - 6 * kT, 1e-8);
}

TEST(CartesianReferenceTest, TheRotationsVelocityIsInBaseAxes) {
  // The pose is turned about x by 90 degrees; a turn about the base's z follows.
  const Eigen::Quaterniond first(Eigen::AngleAxisd(std::numbers::pi / 2, Eigen::Vector3d::UnitX()));
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(1e-3, Eigen::Vector3d::UnitZ()));
  const auto reference = CartesianReference::Rest(model::Pose(first, {0, 0, 0}), {0, -1})
                             .AfterPose(model::Pose(turn * first, {0, 0, 0}));
  EXPECT_NEAR(reference.O_dP_EE_c[5], 1, 1e-12);
  EXPECT_NEAR(reference.O_dP_EE_c[3], 0, 1e-12);
  EXPECT_NEAR(reference.O_dP_EE_c[4], 0, 1e-12);
}

TEST(CartesianReferenceTest, ATwistMovesThePoseOnFromTheLeft) {
  const Eigen::Vector3d axis = Eigen::Vector3d(1, -2, 0.5).normalized();
  const Vector6 twist{0.1, -0.2, 0.3, 0.5, -1.0, 0.25};
  auto reference = CartesianReference::Rest(PoseAt(0.3, 0.7), {0.1, -1});
  for (int k = 0; k < 1000; ++k) reference = reference.AfterTwist(twist);
  const double angle = Eigen::Vector3d(0.5, -1.0, 0.25).norm();
  const Eigen::Quaterniond expected =
      Eigen::AngleAxisd(angle, axis) * Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitZ());
  const Transform X = model::Pose(expected, {0.3 + 0.1, 0.2 - 0.2, 0.4 + 0.3});
  for (std::size_t i = 0; i < 16; ++i) EXPECT_NEAR(reference.O_T_EE_c[i], X[i], 1e-12);
  EXPECT_EQ(reference.O_dP_EE_c, twist);
  EXPECT_EQ(reference.O_ddP_EE_c, Vector6{});
}

TEST(CartesianReferenceTest, ATwistsDerivativesAreItsDifferences) {
  const auto rest = CartesianReference::Rest(kIdentityTransform, {0, -1});
  const auto reference = rest.AfterTwist({0.001, 0, 0, 0, 0, 0.002});
  EXPECT_DOUBLE_EQ(reference.O_ddP_EE_c[0], 1);
  EXPECT_DOUBLE_EQ(reference.O_dddP_EE_c[0], 1000);
  EXPECT_DOUBLE_EQ(reference.O_ddP_EE_c[5], 2);
  EXPECT_DOUBLE_EQ(reference.O_dddP_EE_c[5], 2000);
}

TEST(CartesianReferenceTest, ALossHoldsTheAccelerationOfPoseAndElbow) {
  const auto rest = CartesianReference::Rest(PoseAt(0.3, 0), {0.5, -1});
  const auto first = rest.AfterTwist({0.001, 0, 0, 0, 0, 0.002}).WithElbow({0.500003, -1}, rest);
  const auto next = first.AfterLoss();
  EXPECT_NEAR(next.O_dP_EE_c[0], 0.002, 1e-15);
  EXPECT_NEAR(next.O_dP_EE_c[5], 0.004, 1e-15);
  EXPECT_EQ(next.O_ddP_EE_c, first.O_ddP_EE_c);
  EXPECT_EQ(next.O_dddP_EE_c, Vector6{});
  EXPECT_NEAR(next.O_T_EE_c[12], 0.3 + 3e-6, 1e-15);
  EXPECT_NEAR(model::TurnBetween(first.O_T_EE_c, next.O_T_EE_c)[2], 4e-6, 1e-15);
  EXPECT_NEAR(next.delbow_c, 0.006, 1e-10);
  EXPECT_NEAR(next.elbow_c[0], 0.500009, 1e-13);
  EXPECT_EQ(next.ddelbow_c, first.ddelbow_c);
  EXPECT_EQ(next.dddelbow_c, 0);
  EXPECT_EQ(next.elbow_c[1], -1);
}

TEST(CartesianReferenceTest, APoseThatComesBackAfterALossIsContinuous) {
  // Uniform acceleration: what the loss filled in is what would have come.
  auto reference = CartesianReference::Rest(PoseAt(0.3, 0), {0, -1});
  const auto x = [](int k) { return 0.3 + 0.5 * kT * kT * k * (k + 1); };  // 1 m/s^2
  for (int k = 1; k < 50; ++k) {
    reference = k % 5 == 0 ? reference.AfterLoss() : reference.AfterPose(PoseAt(x(k), 0));
    EXPECT_NEAR(reference.O_T_EE_c[12], x(k), 1e-14);
    EXPECT_NEAR(reference.O_ddP_EE_c[0], 1, 1e-8);
  }
}

TEST(CartesianReferenceTest, TheElbowIsTheCommandedOneOrTheJoints) {
  const auto rest = CartesianReference::Rest(kIdentityTransform, {0.5, -1});
  const auto commanded = rest.AfterPose(kIdentityTransform).WithElbow({0.5001, -1}, rest);
  EXPECT_NEAR(commanded.delbow_c, 0.1, 1e-12);
  EXPECT_NEAR(commanded.ddelbow_c, 100, 1e-9);
  EXPECT_NEAR(commanded.dddelbow_c, 1e5, 1e-6);
  JointReference joints;
  joints.q_d = {0, 0, 0.7, -2, 0, 0, 0};
  joints.dq_d[2] = 1;
  joints.ddq_d[2] = 2;
  joints.dddq_d[2] = 3;
  const auto of_joints = rest.AfterPose(kIdentityTransform).WithElbowOf(joints);
  EXPECT_EQ(of_joints.elbow_c, (Elbow{0.7, -1}));
  EXPECT_EQ(of_joints.delbow_c, 1);
  EXPECT_EQ(of_joints.ddelbow_c, 2);
  EXPECT_EQ(of_joints.dddelbow_c, 3);
}

TEST(CartesianReferenceTest, RepeatingAPoseRestsExactly) {
  const Transform X = PoseAt(0.3, 0.7, Eigen::Vector3d(1, 2, 3).normalized());
  const auto rest = CartesianReference::Rest(X, {0.2, -1});
  EXPECT_TRUE(rest.AtRest());
  const auto next = rest.AfterPose(X).WithElbow({0.2, -1}, rest);
  EXPECT_TRUE(next.AtRest());
  EXPECT_EQ(next.O_dddP_EE_c, Vector6{});
  const auto moving = rest.AfterTwist({0, 0, 0, 0, 0, 0.001});
  EXPECT_FALSE(moving.AtRest());
  const auto stopped = moving.AfterPose(moving.O_T_EE_c);
  EXPECT_EQ(stopped.O_dP_EE_c, Vector6{});
  EXPECT_FALSE(stopped.AtRest());
  EXPECT_TRUE(stopped.AfterPose(moving.O_T_EE_c).AtRest());
}

}  // namespace
}  // namespace twin::onboard::onboard_cartesian_reference_test
