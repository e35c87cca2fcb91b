#include "twin/render/pinhole_camera.h"

#include <gtest/gtest.h>

#include <cmath>

namespace twin::render::pinhole_camera_test {
namespace {

// 90 degrees from bottom to top: the focal length is half the height.
constexpr double kFovyDeg = 90;
constexpr int kWidth = 400;
constexpr int kHeight = 200;

TEST(PinholeCameraTest, ProjectsByFocalLengthOverDepth) {
  const PinholeCamera camera(kIdentityTransform, kFovyDeg, kWidth, kHeight);  // looks along -z
  EXPECT_NEAR(camera.focal_length_px(), 100, 1e-12);
  const auto pixel = camera.Project({0.5, 0.25, -2});
  ASSERT_TRUE(pixel);
  EXPECT_NEAR(pixel->u, 200 + 100 * 0.5 / 2, 1e-12);   // right of the centre
  EXPECT_NEAR(pixel->v, 100 - 100 * 0.25 / 2, 1e-12);  // above it
}

TEST(PinholeCameraTest, SeesNothingBehindItself) {
  const PinholeCamera camera(kIdentityTransform, kFovyDeg, kWidth, kHeight);
  EXPECT_FALSE(camera.Project({0, 0, 1}));
  EXPECT_FALSE(camera.Project({0, 0, 0}));
}

TEST(PinholeCameraTest, FreeCameraPutsItsTargetAtTheCentreFromAnyDirection) {
  for (double azimuth = -180; azimuth <= 180; azimuth += 30) {
    for (double elevation = -80; elevation <= 80; elevation += 20) {
      const FreeCamera free{azimuth, elevation, 3.0, {0.1, -0.2, 0.3}};
      const auto camera = PinholeCamera::FromFreeCamera(free, kFovyDeg, kWidth, kHeight);
      const auto pixel = camera.Project(free.lookat_m);
      ASSERT_TRUE(pixel);
      EXPECT_NEAR(pixel->u, 200, 1e-9);
      EXPECT_NEAR(pixel->v, 100, 1e-9);
    }
  }
}

TEST(PinholeCameraTest, FreeCameraAtAzimuth180LooksDownTheXAxisAndHasYToTheRight) {
  const FreeCamera free{180, 0, 2.0, {0, 0, 0}};
  const auto camera = PinholeCamera::FromFreeCamera(free, kFovyDeg, kWidth, kHeight);
  EXPECT_NEAR(camera.X_WC()[12], 2.0, 1e-12);  // the eye is at x = 2
  const auto pixel = camera.Project({0, 1, 0.5});
  ASSERT_TRUE(pixel);
  EXPECT_NEAR(pixel->u, 200 + 50, 1e-9);
  EXPECT_NEAR(pixel->v, 100 - 25, 1e-9);
}

TEST(PinholeCameraTest, FreeCameraAxesAreOrthonormalAndRightHanded) {
  const auto camera =
      PinholeCamera::FromFreeCamera({37, -21, 1.5, {0, 0, 0}}, kFovyDeg, kWidth, kHeight);
  const Transform& X = camera.X_WC();
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      double dot = 0;
      for (std::size_t k = 0; k < 3; ++k) dot += X[4 * i + k] * X[4 * j + k];
      EXPECT_NEAR(dot, i == j ? 1 : 0, 1e-12);
    }
  }
  EXPECT_NEAR(X[0] * X[5] - X[1] * X[4], X[10], 1e-12);  // z of x cross y
}

}  // namespace
}  // namespace twin::render::pinhole_camera_test
