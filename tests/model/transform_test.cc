#include "twin/model/transform.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>

namespace twin::model::transform_test {
namespace {

using testing::DoubleNear;
using testing::Pointwise;

Eigen::Isometry3d IsometryOf(double x, double y, double angle) {
  return Eigen::Translation3d(x, y, 0.3) *
         Eigen::AngleAxisd(angle, Eigen::Vector3d(1, x, y).normalized());
}

Transform ToTransform(const Eigen::Isometry3d& X) {
  Transform transform;
  Eigen::Map<Eigen::Matrix4d>(transform.data()) = X.matrix();
  return transform;
}

TEST(TransformTest, MultiplyIsTheMatrixProduct) {
  const Eigen::Isometry3d a = IsometryOf(0.1, -0.7, 0.8);
  const Eigen::Isometry3d b = IsometryOf(-1.3, 0.4, 2.1);
  EXPECT_THAT(Multiply(ToTransform(a), ToTransform(b)),
              Pointwise(DoubleNear(1e-15), ToTransform(a * b)));
}

TEST(TransformTest, MultiplyByTheIdentityChangesNoBit) {
  const Transform X = ToTransform(IsometryOf(0.1, -0.7, 0.8));
  EXPECT_EQ(Multiply(X, kIdentityTransform), X);
  EXPECT_EQ(Multiply(kIdentityTransform, X), X);
}

TEST(TransformTest, InverseUndoes) {
  const Transform X = ToTransform(IsometryOf(-1.3, 0.4, 2.1));
  EXPECT_THAT(Multiply(X, Inverse(X)), Pointwise(DoubleNear(1e-15), kIdentityTransform));
  EXPECT_THAT(Multiply(Inverse(X), X), Pointwise(DoubleNear(1e-15), kIdentityTransform));
}

}  // namespace
}  // namespace twin::model::transform_test
