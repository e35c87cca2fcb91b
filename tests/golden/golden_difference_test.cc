#include "twin/golden/difference.h"

#include <gtest/gtest.h>

#include <string_view>

namespace twin::golden::golden_difference_test {
namespace {

/// A mask out of lines of '.' and '#'.
DifferenceMask Mask(std::initializer_list<std::string_view> lines) {
  DifferenceMask mask{static_cast<int>(lines.begin()->size()), static_cast<int>(lines.size()), {}};
  for (const std::string_view line : lines) {
    for (const char c : line) mask.differs.push_back(c == '#' ? 1 : 0);
  }
  return mask;
}

render::SegmentationImage Bodies(int width, std::vector<std::int32_t> bodies) {
  return {width, static_cast<int>(bodies.size()) / width, std::move(bodies)};
}

TEST(DensestWindowTest, CountsTheFullestWindowAndBoxesWhatDiffersInIt) {
  const Difference found =
      DensestWindow(Mask({"#.....", "......", "...##.", "...#..", "......"}), 3);
  EXPECT_EQ(found.window_pixels, 3);
  EXPECT_EQ(found.region, (Region{3, 2, 2, 2}));
}

TEST(DensestWindowTest, FindsWindowsThatTouchEveryEdge) {
  EXPECT_EQ(DensestWindow(Mask({"##..", "....", "...."}), 2).region, (Region{0, 0, 2, 1}));
  EXPECT_EQ(DensestWindow(Mask({"....", "...#", "...#"}), 2).region, (Region{3, 1, 1, 2}));
}

TEST(DensestWindowTest, IsNothingWhenNothingDiffers) {
  const Difference found = DensestWindow(Mask({"...", "..."}), 2);
  EXPECT_EQ(found.window_pixels, 0);
  EXPECT_EQ(found.region, Region());
}

TEST(DensestWindowTest, TakesAWindowLargerThanThePictureAsThePicture) {
  EXPECT_EQ(DensestWindow(Mask({"#.#", "..#"}), 16).window_pixels, 3);
}

TEST(CompareColoursTest, CountsChannelsForTheShareAndPixelsForTheWindow) {
  const render::Image expected(10, 1, {100, 100, 100});
  render::Image actual = expected;
  actual.rgb[0] = 101;                  // within the tolerance of both
  actual.rgb[3] = 102;                  // a channel, no pixel
  actual.rgb[6] = actual.rgb[7] = 103;  // two channels, one pixel
  const Difference found = CompareColours(expected, actual, std::vector<bool>(10),
                                          {.channel = 1, .pixel = 2, .scenery = 9}, 4);
  EXPECT_DOUBLE_EQ(found.share, 3.0 / 30);
  EXPECT_EQ(found.window_pixels, 1);
  EXPECT_EQ(found.region, (Region{2, 0, 1, 1}));
}

TEST(CompareColoursTest, LetsSceneryDifferByMore) {
  const render::Image expected(2, 1, {100, 100, 100});
  const render::Image actual(2, 1, {105, 100, 100});
  const ColourTolerance tolerance{.channel = 1, .pixel = 2, .scenery = 5};
  const Difference found = CompareColours(expected, actual, {true, false}, tolerance, 2);
  EXPECT_DOUBLE_EQ(found.share, 1.0 / 6);
  EXPECT_EQ(found.region, (Region{1, 0, 1, 1}));
}

TEST(SceneryOfTest, IsWhereNeitherPictureShowsABodyOfTheRun) {
  EXPECT_EQ(SceneryOf(Bodies(4, {-1, 0, 1, 0}), Bodies(4, {0, 0, 0, 2})),
            (std::vector<bool>{true, true, false, false}));
}

TEST(CompareDepthsTest, CountsWhatIsFurtherOffThanToleratedOrThereInOneAlone) {
  const render::DepthImage expected{5, 1, {1, 1, 1, 0, 0}};
  const render::DepthImage actual{5, 1, {1.0009F, 1.0012F, 0, 5, 0}};
  const Difference found = CompareDepths(expected, actual, 1e-3, 5);
  EXPECT_DOUBLE_EQ(found.share, 3.0 / 5);
  EXPECT_EQ(found.window_pixels, 3);
}

TEST(CompareDepthsTest, CountsASurfaceWithinToleranceOfTheBackgroundsValue) {
  EXPECT_EQ(CompareDepths({1, 1, {0.0005F}}, {1, 1, {0}}, 1e-3, 1).window_pixels, 1);
}

TEST(CompareBodiesTest, CountsPixelsThatShowAnotherBody) {
  const Difference found = CompareBodies(Bodies(4, {-1, 0, 1, 2}), Bodies(4, {-1, 1, 1, -1}), 4);
  EXPECT_DOUBLE_EQ(found.share, 0.5);
  EXPECT_EQ(found.region, (Region{1, 0, 3, 1}));
}

TEST(BodyUnderTest, IsTheOneOfMostPixelsThatDiffer) {
  const auto before = Bodies(5, {3, 3, 3, 1, 0});
  const auto after = Bodies(5, {3, 3, 3, 0, 0});
  EXPECT_EQ(BodyUnder(before, after, {0, 0, 5, 1}), 1);
}

TEST(BodyUnderTest, IsTheOneOfMostPixelsWhereNoneDiffers) {
  const auto bodies = Bodies(4, {0, 0, 2, 2});
  EXPECT_EQ(BodyUnder(bodies, bodies, {0, 0, 4, 1}), 2);
}

TEST(BodyUnderTest, IsTheWorldOrTheBackgroundOnlyWhereNothingElseIs) {
  const auto world = Bodies(3, {0, -1, -1});
  EXPECT_EQ(BodyUnder(world, world, {0, 0, 3, 1}), 0);
  EXPECT_EQ(BodyUnder(world, world, {1, 0, 2, 1}), render::SegmentationImage::kBackground);
}

}  // namespace
}  // namespace twin::golden::golden_difference_test
