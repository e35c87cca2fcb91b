#include "twin/golden/signature.h"

#include <gtest/gtest.h>

namespace twin::golden::golden_signature_test {
namespace {

TEST(SignatureTest, IsTheRoundedMeanOfEachBox) {
  render::Image picture(4 * kSignatureWidth, 2 * kSignatureHeight, {10, 20, 30});
  // In the box of 4 x 2 pixels at column 3, row 5: red 10 * 7 + 94, mean 20.5, rounded up.
  picture.rgb[picture.Offset(4 * 3 + 1, 2 * 5 + 1)] = 94;
  render::Image expected(kSignatureWidth, kSignatureHeight, {10, 20, 30});
  expected.rgb[expected.Offset(3, 5)] = 21;
  EXPECT_EQ(SignatureOf(picture), expected);
}

TEST(SignatureTest, CoversPicturesWhoseSizeTheBoxesDoNotDivide) {
  render::Image picture(100, 77, {0, 0, 0});
  picture.rgb[picture.Offset(99, 76)] = 255;
  const render::Image signature = SignatureOf(picture);
  // Columns 96 to 99 and rows 73 to 76: 16 pixels.
  EXPECT_EQ(signature.at(kSignatureWidth - 1, kSignatureHeight - 1), (render::Rgb{16, 0, 0}));
}

TEST(SignatureTest, FindsTheChannelMostOff) {
  const render::Image expected(kSignatureWidth, kSignatureHeight, {50, 50, 50});
  render::Image actual = expected;
  actual.rgb[actual.Offset(2, 1)] = 53;
  actual.rgb[actual.Offset(30, 22) + 2] = 43;
  const SignatureDifference off = CompareSignatures(expected, actual);
  EXPECT_EQ(off.levels, 7);
  EXPECT_EQ(off.column, 30);
  EXPECT_EQ(off.row, 22);
}

TEST(SignatureTest, StripsGiveBackWhatTheyWereMadeOf) {
  std::vector<render::Image> signatures;
  for (std::uint8_t i = 0; i < kStripColumns + 3; ++i) {
    signatures.emplace_back(kSignatureWidth, kSignatureHeight, render::Rgb{i, 1, 2});
    signatures.back().rgb[i] = 200;
  }
  const render::Image strip = JoinSignatures(signatures);
  EXPECT_EQ(strip.height, 2 * kSignatureHeight);
  EXPECT_EQ(SplitSignatures(strip, signatures.size()), signatures);
}

TEST(SignatureTest, StripsOfAnotherSizeGiveNothing) {
  const render::Image strip(kStripColumns * kSignatureWidth, kSignatureHeight);
  EXPECT_TRUE(SplitSignatures(strip, kStripColumns + 1).empty());
  EXPECT_TRUE(SplitSignatures(render::Image(7, 7), 1).empty());
}

}  // namespace
}  // namespace twin::golden::golden_signature_test
