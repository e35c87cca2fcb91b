#include "twin/model/transform.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "support/pose_samples.h"

namespace twin::model::model_rotation_test {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using test::Obliqueness;
using test::PoseOf;
using test::PositionOf;
using test::RandomPose;
using test::RandomVector;
using test::RotationOf;

/// Rodrigues' formula in full: 1 + sin(x) K + (1 - cos(x)) K^2.
Matrix3d Rodrigues(const Vector3d& phi) {
  const double angle = phi.norm();
  if (angle == 0) return Matrix3d::Identity();
  const Vector3d n = phi / angle;
  Matrix3d K;
  K << 0, -n[2], n[1], n[2], 0, -n[0], -n[1], n[0], 0;
  return Matrix3d::Identity() + std::sin(angle) * K + (1 - std::cos(angle)) * K * K;
}

TEST(RotationTest, ExpIsRodriguesFormula) {
  const Random random(1, RandomStream::kTest);
  for (std::uint64_t k = 0; k < 1000; ++k) {
    const Vector3d phi = std::pow(10.0, -8 * random.Uniform(k, 9)) * 3 * RandomVector(random, k, 0);
    EXPECT_LT((Exp(phi).toRotationMatrix() - Rodrigues(phi)).cwiseAbs().maxCoeff(), 2e-15);
  }
  EXPECT_EQ(Exp(Vector3d::Zero()).toRotationMatrix(), Matrix3d::Identity());
}

TEST(RotationTest, LogIsTheInverseOfExpUpToHalfATurn) {
  const Random random(2, RandomStream::kTest);
  for (std::uint64_t k = 0; k < 1000; ++k) {
    const double angle = std::numbers::pi * std::pow(10.0, -10 * random.Uniform(k, 9)) * 0.999999;
    const Vector3d phi = angle * RandomVector(random, k, 0).normalized();
    EXPECT_LT((Log(Exp(phi)) - phi).norm(), 1e-15 + 1e-15 * angle) << phi.transpose();
    // The other sign of the quaternion is the same rotation.
    Eigen::Quaterniond other = Exp(phi);
    other.coeffs() *= -1;
    EXPECT_LT((Log(other) - phi).norm(), 1e-15 + 1e-15 * angle) << phi.transpose();
  }
}

TEST(RotationTest, TurnBetweenResolvesTinyTurns) {
  // What a velocity of 1e-6 rad/s turns in a cycle, from any orientation.
  const Random random(3, RandomStream::kTest);
  for (std::uint64_t k = 0; k < 1000; ++k) {
    const Transform from = RandomPose(random, k);
    const Vector3d phi = 1e-9 * RandomVector(random, k, 10);
    const Transform to = Turned(from, phi, PositionOf(from));
    EXPECT_LT((TurnBetween(from, to) - phi).norm(), 2e-15);
  }
}

TEST(RotationTest, StraightensAnObliqueRotation) {
  Transform oblique = PoseOf({0.3, -0.2, 0.9}, {0, 0, 0});
  for (std::size_t i = 0; i < 3; ++i) oblique[i] *= 1 + 1e-6;
  const Transform straight = Pose(Orientation(oblique), Position(oblique));
  EXPECT_LT(Obliqueness(straight), 1e-15);
  EXPECT_LT((RotationOf(straight) - RotationOf(oblique)).cwiseAbs().maxCoeff(), 2e-6);
}

TEST(RotationTest, ATurnBelowResolutionLeavesTheRotationBitForBit) {
  const Random random(4, RandomStream::kTest);
  for (std::uint64_t k = 0; k < 100; ++k) {
    const Transform X = RandomPose(random, k);
    const Transform moved = Turned(X, {1e-15, 0, -1e-15}, {1, 2, 3});
    EXPECT_EQ(RotationOf(moved), RotationOf(X));
    EXPECT_EQ(PositionOf(moved), Vector3d(1, 2, 3));
    EXPECT_NE(RotationOf(Turned(X, {1e-14, 1e-14, 1e-14}, {1, 2, 3})), RotationOf(X));
  }
}

}  // namespace
}  // namespace twin::model::model_rotation_test
