#include "twin/render/link_mask.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

#include "render/test_model.h"

namespace twin::render::link_mask_test {
namespace {

constexpr std::array<int, 1> kBody{3};

/// 10 x 10 pixels, one of which, (4, 5), shows body 3.
SegmentationImage OnePixel() {
  SegmentationImage image{10, 10, std::vector<std::int32_t>(100, SegmentationImage::kBackground)};
  image.body[5 * 10 + 4] = kBody[0];
  return image;
}

TEST(DistanceToMaskTest, IsZeroAnywhereInsideAPixelOfTheMask) {
  EXPECT_EQ(DistanceToMask(OnePixel(), kBody, {4.0, 5.0}), 0);
  EXPECT_EQ(DistanceToMask(OnePixel(), kBody, {4.99, 5.5}), 0);
}

TEST(DistanceToMaskTest, IsEuclideanToThePixelsEdge) {
  EXPECT_DOUBLE_EQ(*DistanceToMask(OnePixel(), kBody, {1.0, 5.5}), 3);
  EXPECT_DOUBLE_EQ(*DistanceToMask(OnePixel(), kBody, {8.0, 10.0}), 5);   // 3 right, 4 down
  EXPECT_DOUBLE_EQ(*DistanceToMask(OnePixel(), kBody, {-6.0, 5.5}), 10);  // from outside the frame
}

TEST(DistanceToMaskTest, IsNothingForAnEmptyMask) {
  EXPECT_FALSE(DistanceToMask(OnePixel(), std::array<int, 1>{4}, {4.0, 5.0}));
}

/// Joint origins of kArmMjcf by hand: the lower link stands at z = 0.1, the upper starts 0.4
/// further.
std::vector<LinkPoint> Origins(const Renderer& renderer, double q0, double upper_shift_m = 0) {
  return {{"lower", {renderer.BodyId("lower")}, {0, 0, 0.1}},
          {"upper",
           {renderer.BodyId("upper")},
           {0.4 * std::sin(q0) + upper_shift_m, 0, 0.1 + 0.4 * std::cos(q0)}}};
}

RenderSettings SideView() {
  RenderSettings settings;
  settings.camera = "side";
  settings.width = 320;
  settings.height = 240;
  return settings;
}

TEST(CheckLinkMasksTest, FindsEachLinkWhereItIsComputed) {
  const TestModel model(kArmMjcf);
  Renderer renderer(model.model(), SideView());
  for (const double q0 : {-0.8, 0.0, 0.5}) {
    const std::vector<double> qpos{q0, 1.0};
    for (const LinkMaskCheck& check : CheckLinkMasks(renderer, qpos, Origins(renderer, q0))) {
      ASSERT_TRUE(check.distance_px) << check.name;
      EXPECT_EQ(*check.distance_px, 0) << check.name << " at " << q0;
      EXPECT_GT(check.mask_pixels, 300U) << check.name;
    }
  }
}

TEST(CheckLinkMasksTest, TellsByHowManyPixelsALinkIsOff) {
  const TestModel model(kArmMjcf);
  Renderer renderer(model.model(), SideView());
  // Upright, the upper link reaches 0.04 m to the left of its origin: a point 0.1 m to the left is
  // 0.06 m off, at 2 m from the camera.
  const auto checks = CheckLinkMasks(renderer, model.Qpos(), Origins(renderer, 0, -0.1));
  const double px_per_m = 120 / std::tan(25 * M_PI / 180) / 2;
  ASSERT_TRUE(checks[1].distance_px);
  EXPECT_NEAR(*checks[1].distance_px, 0.06 * px_per_m, 1.0);
}

TEST(CheckLinkMasksTest, TellsWhenAPointIsBehindTheCamera) {
  const TestModel model(kArmMjcf);
  Renderer renderer(model.model(), SideView());
  const std::array<LinkPoint, 1> points{{{"lower", {renderer.BodyId("lower")}, {0, -3, 0}}}};
  const auto checks = CheckLinkMasks(renderer, model.Qpos(), points);
  EXPECT_FALSE(checks[0].pixel);
  EXPECT_FALSE(checks[0].distance_px);
}

}  // namespace
}  // namespace twin::render::link_mask_test
