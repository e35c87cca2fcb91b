#include "twin/render/image_operations.h"

#include <gtest/gtest.h>

#include <vector>

namespace twin::render::contact_sheet_test {
namespace {

constexpr Rgb kRed{200, 10, 10};
constexpr Rgb kGreen{10, 200, 10};
constexpr Rgb kBlue{10, 10, 200};
constexpr Rgb kBorder{1, 2, 3};

TEST(ContactSheetTest, LaysPicturesOutRowByRowWithBordersBetweenThem) {
  const std::vector<Image> images{Image(6, 4, kRed), Image(6, 4, kGreen), Image(6, 4, kBlue)};
  const Image sheet =
      ComposeContactSheet(images, {.columns = 2, .border_px = 3, .border = kBorder});

  ASSERT_EQ(sheet.width, 3 + 2 * (6 + 3));
  ASSERT_EQ(sheet.height, 3 + 2 * (4 + 3));
  for (int row = 0; row < sheet.height; ++row) {
    for (int column = 0; column < sheet.width; ++column) {
      const bool left = column >= 3 && column < 9;
      const bool right = column >= 12 && column < 18;
      const bool upper = row >= 3 && row < 7;
      const bool lower = row >= 10 && row < 14;
      const Rgb expected = upper && left    ? kRed
                           : upper && right ? kGreen
                           : lower && left  ? kBlue
                                            : kBorder;
      ASSERT_EQ(sheet.at(column, row), expected) << column << ", " << row;
    }
  }
}

TEST(ContactSheetTest, IsNoWiderThanItsPictures) {
  const std::vector<Image> images{Image(6, 4, kRed)};
  EXPECT_EQ(ComposeContactSheet(images, {.columns = 4, .border_px = 0}), images[0]);
}

TEST(HalveImageTest, TakesTheMeanOfFourPixels) {
  Image image(3, 2);
  image.rgb = {0, 10, 100, 1, 20, 100, 9, 9, 9, 2, 30, 100, 4, 41, 101, 9, 9, 9};
  const Image half = HalveImage(image);
  EXPECT_EQ(half.width, 1);
  EXPECT_EQ(half.height, 1);
  EXPECT_EQ(half.at(0, 0), (Rgb{2, 25, 100}));  // (7 + 2) / 4, (101 + 2) / 4, (401 + 2) / 4
}

TEST(SpreadFramesTest, TakesFirstAndLastAndSpreadsTheOthers) {
  EXPECT_EQ(SpreadFrames(11, 3), (std::vector<std::size_t>{0, 5, 10}));
  EXPECT_EQ(SpreadFrames(3, 5), (std::vector<std::size_t>{0, 1, 2}));
  EXPECT_EQ(SpreadFrames(0, 5), (std::vector<std::size_t>{}));
}

}  // namespace
}  // namespace twin::render::contact_sheet_test
