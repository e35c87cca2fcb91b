#include "twin/render/image_operations.h"

#include <gtest/gtest.h>

#include "twin/core/error.h"

namespace twin::render::ssim_test {
namespace {

/// Stripes of `width_px`, as far right as `shift_px`.
Image Stripes(int width_px, int shift_px) {
  Image image(64, 48, {40, 60, 80});
  for (int row = 0; row < image.height; ++row) {
    for (int column = 0; column < image.width; ++column) {
      if ((column + shift_px) / width_px % 2 == 0) image.rgb[image.Offset(column, row)] = 220;
    }
  }
  return image;
}

TEST(SsimTest, IsOneForTheSameAndLessTheMoreDiffers) {
  const std::vector<Image> expected(3, Stripes(8, 0));
  const std::vector<Image> actual{Stripes(8, 0), Stripes(8, 1), Stripes(8, 4)};
  const std::vector<double> ssim = MeasureSsim(expected, actual);
  ASSERT_EQ(ssim.size(), 3U);
  EXPECT_EQ(ssim[0], 1);
  EXPECT_LT(ssim[1], 0.99);
  EXPECT_LT(ssim[2], ssim[1]);
}

TEST(SsimTest, IsNothingForNothing) {
  EXPECT_TRUE(MeasureSsim({}, {}).empty());
}

TEST(SsimTest, TellsWhenFfmpegIsNotThereOrFails) {
  const std::vector<Image> image{Stripes(8, 0)};
  EXPECT_THROW(static_cast<void>(MeasureSsim(image, image, "no-such-ffmpeg")), EnvironmentError);
  EXPECT_THROW(static_cast<void>(MeasureSsim(image, image, "false")), EnvironmentError);
  EXPECT_THROW(static_cast<void>(MeasureSsim(image, image, "cat")), EnvironmentError);
}

}  // namespace
}  // namespace twin::render::ssim_test
