#include "twin/golden/comparison.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>

#include "golden/made_up_golden.h"
#include "twin/core/error.h"

namespace twin::golden::golden_comparison_test {
namespace {

using testing::HasSubstr;

class ComparisonTest : public testing::Test {
 protected:
  /// What comes of the pictures after a change.
  Comparison After(const std::function<void(Pictures&)>& change, std::uint64_t states = 7) {
    change(actual_);
    return Compare(golden_, {&actual_, states, {}});
  }
  static const GateResult& Of(const Comparison& comparison, Gate gate) {
    return comparison.gates[static_cast<std::size_t>(gate)];
  }
  /// The gates that did not pass, the first two left out.
  static std::vector<Gate> Failed(const Comparison& comparison) {
    std::vector<Gate> failed;
    for (const GateResult& gate : comparison.gates) {
      if (!gate.passed && gate.gate > Gate::kHashes) failed.push_back(gate.gate);
    }
    return failed;
  }

  Pictures actual_ = GreyPictures();
  Golden golden_ = GoldenOf(GreyPictures());
};

TEST_F(ComparisonTest, TheSameIsTheSame) {
  const Comparison same = After([](Pictures&) {});
  EXPECT_EQ(same.verdict, Verdict::kSame);
  EXPECT_TRUE(same.passed());
  EXPECT_EQ(same.FirstFailure(), nullptr);
  for (const GateResult& gate : same.gates) EXPECT_EQ(gate.worst, 0) << Name(gate.gate);
}

TEST_F(ComparisonTest, OtherBitsThatLookTheSameAreRenderingOnly) {
  const Comparison other = After([](Pictures& pictures) {
    pictures.views[0].hashes[3] ^= 1;
    pictures.views[0].keys[1].colour.rgb[0] += 1;
  });
  EXPECT_EQ(other.verdict, Verdict::kRenderingOnly);
  EXPECT_TRUE(other.passed());
  EXPECT_EQ(Of(other, Gate::kHashes).worst, 1);
  EXPECT_EQ(Of(other, Gate::kHashes).first->frame, 3U);
}

TEST_F(ComparisonTest, AnyApprovedRenderingOfAFrameWillDo) {
  golden_.renderings.push_back(golden_.renderings[0]);
  golden_.renderings[1][0][3] = 42;
  EXPECT_EQ(After([](Pictures& pictures) { pictures.views[0].hashes[3] = 42; }).verdict,
            Verdict::kSame);
}

TEST_F(ComparisonTest, OtherStatesThatLookTheSamePass) {
  const Comparison other = After([](Pictures&) {}, 8);
  EXPECT_EQ(other.verdict, Verdict::kStatesOnly);
  EXPECT_TRUE(other.passed());
}

TEST_F(ComparisonTest, TellsPhysicsFromRendering) {
  const auto change = [](Pictures& pictures) {
    for (std::uint8_t& byte : pictures.views[1].keys[0].colour.rgb) byte += 3;
  };
  EXPECT_EQ(After(change).verdict, Verdict::kRenderingChanged);
  actual_ = GreyPictures();
  const Comparison other = After(change, 8);
  EXPECT_EQ(other.verdict, Verdict::kPhysicsChanged);
  EXPECT_FALSE(other.passed());
}

TEST_F(ComparisonTest, NamesFrameViewRegionBodyAndGate) {
  const Comparison other = After([](Pictures& pictures) {
    render::Image& picture = pictures.views[1].keys[1].colour;
    for (int row = 10; row < 14; ++row) {
      for (int column = 40; column < 44; ++column) picture.rgb[picture.Offset(column, row)] -= 10;
    }
  });
  EXPECT_EQ(Failed(other), std::vector<Gate>{Gate::kColourWindow});
  EXPECT_EQ(Describe(other, actual_),
            "the rendering changed: the states are approved ones, the pictures are not; first at "
            "frame 4 (0.80 s), view hand, pixels (40, 10) to (43, 13), on link, by the gate of "
            "colour window (16, at most 12)");
}

TEST_F(ComparisonTest, NamesABodyOfTheRunBeforeTheWorldWhereAFrameHasBoth) {
  const Comparison other = After([](Pictures& pictures) {
    pictures.views[0].signatures[0].rgb[0] = 0;  // where the world is seen
    auto& depths = pictures.views[0].keys[0].depth.depth_m;
    for (std::size_t i = 0; i < depths.size(); ++i) depths[i] += i % 64 < 32 ? 0 : 0.1F;
  });
  EXPECT_EQ(other.FirstFailure()->gate, Gate::kDepths);
  EXPECT_EQ(other.FirstFailure()->first->frame, 0U);
}

TEST_F(ComparisonTest, FindsAFilmOfOtherLength) {
  for (const std::size_t frames : {4U, 6U}) {
    actual_ = GreyPictures(frames);
    actual_.views[0].keys.resize(1);  // the last is of another frame
    actual_.views[1].keys.resize(1);
    const Comparison other = After([](Pictures&) {});
    EXPECT_EQ(Failed(other), std::vector<Gate>{Gate::kFrames});
    EXPECT_EQ(Of(other, Gate::kFrames).worst, 1);
    EXPECT_EQ(other.FirstFailure()->first->frame, std::min<std::size_t>(frames, 5));
  }
}

TEST_F(ComparisonTest, FindsAFrameOutOfPlaceThatIsNoKeyPicture) {
  const Comparison other = After([](Pictures& pictures) {
    pictures.views[0].signatures[2] = pictures.views[0].signatures[3];
  });
  EXPECT_EQ(Failed(other), std::vector<Gate>{Gate::kSignatures});
  EXPECT_EQ(other.FirstFailure()->first->frame, 2U);
  EXPECT_EQ(other.FirstFailure()->worst, 20);
}

TEST_F(ComparisonTest, LooksUpTheBodyOfAFrameThatIsNoKeyPicture) {
  actual_.views[1].signatures[2].rgb[0] = 0;
  const Comparison other = Compare(
      golden_, {&actual_, 7, [](std::size_t view, std::size_t frame) {
                  EXPECT_EQ(view, 1U);
                  EXPECT_EQ(frame, 2U);
                  return render::SegmentationImage{64, 48, std::vector<std::int32_t>(3072, 2)};
                }});
  EXPECT_EQ(other.FirstFailure()->first->body, "parcel");
}

TEST_F(ComparisonTest, FindsASurfaceThatIsElsewhere) {
  const Comparison other = After([](Pictures& pictures) {
    for (float& depth : pictures.views[0].keys[0].depth.depth_m) depth += 0.0013F;
  });
  EXPECT_EQ(Failed(other), (std::vector<Gate>{Gate::kDepths, Gate::kDepthWindow}));
  EXPECT_DOUBLE_EQ(Of(other, Gate::kDepths).worst, 100);
}

TEST_F(ComparisonTest, ComparesBodiesByName) {
  const Comparison renumbered = After([](Pictures& pictures) {
    pictures.bodies = {"world", "new", "parcel", "link"};
    for (ViewPictures& view : pictures.views) {
      for (KeyPicture& key : view.keys) {
        for (std::int32_t& body : key.bodies.body) body = body == 1 ? 3 : body;
      }
    }
  });
  EXPECT_EQ(renumbered.verdict, Verdict::kSame);
  const Comparison other = After([](Pictures& pictures) {
    auto& bodies = pictures.views[0].keys[0].bodies.body;
    for (std::int32_t& body : bodies) body = body == 3 ? 1 : body;
  });
  EXPECT_EQ(Failed(other), (std::vector<Gate>{Gate::kBodies, Gate::kBodyWindow}));
  EXPECT_EQ(other.FirstFailure()->first->body, "link");
}

TEST_F(ComparisonTest, RefusesOtherViewsSizesAndIntervals) {
  const std::pair<const char*, std::function<void(Pictures&)>> changes[] = {
      {"overview (64 x 48), side (64 x 48)", [](Pictures& p) { p.views[1].name = "side"; }},
      {"overview (64 x 60)", [](Pictures& p) { p.views[0].height = 60; }},
      {"the case overview (64 x 48). The case was changed",
       [](Pictures& p) { p.views.pop_back(); }},
      {"a frame each 0.2 s, the case each 0.1 s", [](Pictures& p) { p.interval_s = 0.1; }}};
  for (const auto& [says, change] : changes) {
    actual_ = GreyPictures();
    try {
      After(change);
      ADD_FAILURE() << says;
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr(says));
    }
  }
}

}  // namespace
}  // namespace twin::golden::golden_comparison_test
