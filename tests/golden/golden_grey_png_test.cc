#include "golden/golden_files.h"

#include <gtest/gtest.h>

#include <cmath>

#include "support/temporary_folder.h"
#include "twin/core/error.h"
#include "twin/render/image.h"

namespace twin::golden::golden_grey_png_test {
namespace {

class GreyPngTest : public testing::Test {
 protected:
  test::TemporaryFolder folder_;
  std::filesystem::path path_ = folder_ / "picture.png";
};

TEST_F(GreyPngTest, EveryDepthComesBackToTheUnit) {
  render::DepthImage image{256, 256, {}};
  for (int i = 0; i < 65536; ++i) image.depth_m.push_back(static_cast<float>(i * kDepthUnit));
  WriteDepths(path_, image);
  EXPECT_EQ(ReadDepths(path_), image);
}

TEST_F(GreyPngTest, DepthsAreRoundedToTheUnitAndCutAtTheLargest) {
  WriteDepths(path_, {4, 1, {1.00012F, 1.00013F, 0.00001F, 40}});
  const render::DepthImage read = ReadDepths(path_);
  EXPECT_FLOAT_EQ(read.depth_m[0], 1.0F);
  EXPECT_FLOAT_EQ(read.depth_m[1], 1.00025F);
  EXPECT_FLOAT_EQ(read.depth_m[2], 0.00025F) << "near is not nothing";
  EXPECT_FLOAT_EQ(read.depth_m[3], 16.38375F);
}

TEST_F(GreyPngTest, WhatIsRoundedIsWhatAFileGivesBack) {
  const render::DepthImage image{3, 1, {0, 1.2345678F, 40}};
  WriteDepths(path_, image);
  EXPECT_EQ(ReadDepths(path_), RoundedDepths(image));
}

TEST_F(GreyPngTest, BodiesComeBack) {
  render::SegmentationImage image{16, 16, {}};
  for (int i = 0; i < 256; ++i) image.body.push_back(i - 1);
  WriteBodies(path_, image);
  EXPECT_EQ(ReadBodies(path_), image);
}

TEST_F(GreyPngTest, APictureOfAnotherSortIsRefused) {
  render::WritePng(path_, render::Image(4, 4));
  EXPECT_THROW(static_cast<void>(ReadDepths(path_)), InputError);
  EXPECT_THROW(static_cast<void>(ReadBodies(path_)), InputError);
  WriteBodies(path_, {1, 1, {3}});
  EXPECT_THROW(static_cast<void>(ReadDepths(path_)), InputError);
}

TEST_F(GreyPngTest, ADamagedFileIsRefused) {
  WriteDepths(path_, {64, 64, std::vector<float>(4096, 1.5F)});
  std::filesystem::resize_file(path_, std::filesystem::file_size(path_) / 2);
  EXPECT_THROW(static_cast<void>(ReadDepths(path_)), InputError);
  EXPECT_THROW(static_cast<void>(ReadDepths(folder_ / "missing.png")), InputError);
}

TEST_F(GreyPngTest, AFolderThatIsNotThereIsTold) {
  EXPECT_THROW(WriteDepths(folder_ / "no/such.png", {1, 1, {1}}), EnvironmentError);
}

}  // namespace
}  // namespace twin::golden::golden_grey_png_test
