#include "twin/replay/comparison.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <string>
#include <vector>

#include "replay/sample_log.h"
#include "support/temporary_folder.h"
#include "twin/core/error.h"
#include "twin/render/frame_painter.h"

namespace twin::replay::replay_comparison_test {
namespace {

using render::Image;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr render::Rgb kRed{230, 30, 30};

TEST(SideBySideTest, PutsALightLineBetween) {
  const Image left(4, 2, {10, 20, 30});
  const Image right(6, 2, {40, 50, 60});
  const Image both = SideBySide(left, right);
  EXPECT_EQ(both.width, 10);
  EXPECT_EQ(both.height, 2);
  for (const int row : {0, 1}) {
    EXPECT_EQ(both.at(2, row), (render::Rgb{10, 20, 30}));
    EXPECT_GT(both.at(3, row)[0], 200);
    EXPECT_GT(both.at(4, row)[0], 200);
    EXPECT_EQ(both.at(5, row), (render::Rgb{40, 50, 60}));
  }
}

TEST(HighlightDifferenceTest, MarksWhatDiffersByMoreThanTheTolerance) {
  const Image first(2, 1, {100, 100, 100});
  Image second = first;
  second.rgb[1] = 116;  // by 16: within
  second.rgb[5] = 83;   // by 17: beyond, and in one channel only
  const Image shown = HighlightDifference(first, first, second, 16);
  EXPECT_EQ(shown.at(0, 0), (render::Rgb{100, 100, 100}));
  EXPECT_EQ(shown.at(1, 0), kRed);
}

TEST(HighlightDifferenceTest, ShowsTheRestInGrey) {
  const Image first(1, 1, {10, 20, 60});
  EXPECT_EQ(HighlightDifference(first, first, first, 0).at(0, 0), (render::Rgb{30, 30, 30}));
}

/// Two recordings of the sample arm without scenes, the second 40 ms longer; each in primitive
/// shapes.
class ComparisonTest : public testing::Test {
 protected:
  ComparisonTest()
      : first_(Log("a", 201, 0), test::Files()), second_(Log("b", 241, 50), test::Files()) {
    settings_.film.render.width = 96;
    settings_.film.render.height = 72;
    settings_.film.render.shadow_size = 128;
    settings_.film.overlays.text = false;
  }

  /// @param later  by how many ms the arm is ahead.
  std::filesystem::path Log(const std::string& name, std::uint64_t cycles, std::uint64_t later) {
    std::filesystem::path path = folder_ / (name + ".mcap");
    record::Recorder recorder(path, test::InfoOf(test::Sample()), record::FullRing::kWait);
    for (std::uint64_t k = 0; k < cycles; ++k) {
      record::CycleRecord cycle = test::CycleAt(k);
      cycle.state.q = test::ArmAt(cycle.at + std::chrono::seconds(later));
      recorder.Put(cycle);
    }
    recorder.Finish();
    return path;
  }

  [[nodiscard]] Image FrameOf(ComparisonKind kind, std::size_t frame, const Recording& second) {
    settings_.kind = kind;
    const Comparison comparison(first_, second, settings_, {"a", "b"});
    return comparison.Frames().new_drawer()(frame);
  }

  [[nodiscard]] Image Alone(const Recording& recording, std::size_t frame) const {
    const render::Film film = recording.Film();
    return render::FramePainter(film, settings_.film).Paint(frame);
  }

  twin::test::TemporaryFolder folder_;
  Recording first_;
  Recording second_;
  ComparisonSettings settings_;
};

TEST_F(ComparisonTest, GoesOnUntilTheLongerRunEnds) {
  const Comparison comparison(first_, second_, settings_, {"a", "b"});
  EXPECT_EQ(comparison.Frames().count, 7U) << "at 0, 40, ... 240 ms";
  EXPECT_EQ(comparison.Frames().width, 192);
}

TEST_F(ComparisonTest, SplitShowsEachAsItIsAlone) {
  EXPECT_EQ(FrameOf(ComparisonKind::kSplit, 2, second_),
            SideBySide(Alone(first_, 2), Alone(second_, 2)));
}

TEST_F(ComparisonTest, WhoHasEndedStaysAsItWas) {
  EXPECT_EQ(FrameOf(ComparisonKind::kSplit, 6, second_),
            SideBySide(Alone(first_, 5), Alone(second_, 6)));
}

TEST_F(ComparisonTest, GhostAddsTheOtherArmWhereItDiffers) {
  EXPECT_EQ(FrameOf(ComparisonKind::kGhost, 2, first_), Alone(first_, 2)) << "the same arm";
  EXPECT_NE(FrameOf(ComparisonKind::kGhost, 2, second_), Alone(first_, 2));
}

TEST_F(ComparisonTest, DifferenceIsRedOnlyWhereTheyDiffer) {
  const auto reds = [](const Image& image) {
    int count = 0;
    for (int row = 0; row < image.height; ++row) {
      for (int column = 0; column < image.width; ++column) {
        count += image.at(column, row) == kRed ? 1 : 0;
      }
    }
    return count;
  };
  EXPECT_EQ(reds(FrameOf(ComparisonKind::kDifference, 2, first_)), 0);
  EXPECT_GT(reds(FrameOf(ComparisonKind::kDifference, 2, second_)), 50);
}

TEST_F(ComparisonTest, SaysThatLengthsDiffer) {
  EXPECT_THAT(Comparison(first_, second_, settings_, {"a", "b"}).Notes(),
              ElementsAre(HasSubstr("the first run took 0.200 s, the second 0.240 s")));
  EXPECT_THAT(Comparison(first_, first_, settings_, {"a", "b"}).Notes(), IsEmpty());
}

TEST_F(ComparisonTest, RefusesAToleranceOutOfRange) {
  settings_.tolerance = 255;
  EXPECT_THROW(Comparison(first_, second_, settings_, {"a", "b"}), InputError);
}

TEST(ComparisonFromNameTest, NamesThoseThereAre) {
  EXPECT_EQ(ComparisonFromName("ghost"), ComparisonKind::kGhost);
  try {
    static_cast<void>(ComparisonFromName("blink"));
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("split, ghost, difference"));
  }
}

}  // namespace
}  // namespace twin::replay::replay_comparison_test
