#include "twin/golden/golden.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <functional>

#include "golden/made_up_golden.h"
#include "support/temporary_folder.h"
#include "twin/core/error.h"
#include "twin/render/png.h"

namespace twin::golden {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class GoldenTest : public testing::Test {
 protected:
  GoldenTest() { WriteGolden(at_, golden_); }

  /// What reading says.
  std::string Refusal() {
    try {
      static_cast<void>(ReadGolden(at_));
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }

  void Replace(const std::string& old, const std::string& with) {
    std::string text = test::ReadText(at_ / kGoldenFile);
    const std::size_t begin = text.find(old);
    ASSERT_NE(begin, std::string::npos) << old;
    text.replace(begin, old.size(), with);
    std::ofstream(at_ / kGoldenFile) << text;
  }

  test::TemporaryFolder folder_;
  fs::path at_ = folder_ / "goldens/case";
  Golden golden_ = GoldenOf(GreyPictures());
};

TEST_F(GoldenTest, ComesBackAsItWasWritten) {
  const Golden read = ReadGolden(at_);
  EXPECT_EQ(read.states, golden_.states);
  EXPECT_EQ(read.renderings, golden_.renderings);
  EXPECT_EQ(read.pictures.frames, 5U);
  EXPECT_EQ(read.pictures.interval_s, 0.2);
  EXPECT_EQ(read.pictures.bodies, golden_.pictures.bodies);
  ASSERT_EQ(read.pictures.views.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    const ViewPictures& view = read.pictures.views[i];
    const ViewPictures& written = golden_.pictures.views[i];
    EXPECT_EQ(view.name, written.name);
    EXPECT_EQ(view.signatures, written.signatures);
    ASSERT_EQ(view.keys.size(), 2U);
    EXPECT_EQ(view.keys[1].frame, 4U);
    EXPECT_EQ(view.keys[1].colour, written.keys[1].colour);
    EXPECT_EQ(view.keys[1].depth, written.keys[1].depth);
    EXPECT_EQ(view.keys[1].bodies, written.keys[1].bodies);
  }
}

TEST_F(GoldenTest, KeepsReasonsWhateverTheyHold) {
  golden_.approvals = {{"it's \"so\": \\ # - [x]\nand on", "all", "1.0"},
                       {"again", "hashes", "1.1"}};
  WriteGolden(at_, golden_);
  const Golden read = ReadGolden(at_);
  ASSERT_EQ(read.approvals.size(), 2U);
  EXPECT_EQ(read.approvals[0].reason, "it's \"so\": \\ # - [x] and on");
  EXPECT_EQ(read.approvals[1].version, "1.1");
}

TEST_F(GoldenTest, TheSameGoldenIsTheSameBytes) {
  WriteGolden(folder_ / "other", golden_);
  for (const auto& entry : fs::directory_iterator(at_)) {
    EXPECT_EQ(test::ReadText(entry.path()),
              test::ReadText(folder_ / "other" / entry.path().filename()))
        << entry.path();
  }
}

TEST_F(GoldenTest, ReplacesTheOldOneAndLeavesNothingBeside) {
  golden_.pictures = GreyPictures(3);
  golden_.renderings.clear();
  WriteGolden(at_, golden_);
  EXPECT_EQ(ReadGolden(at_).pictures.frames, 3U);
  EXPECT_FALSE(fs::exists(at_ / "overview_0004.png"));
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_ / "goldens"), {}), 1);
}

TEST_F(GoldenTest, StaysAsItWasWhenTheNewOneCannotBeWritten) {
  golden_.pictures.views[1].name = "no/such/folder";
  EXPECT_THROW(WriteGolden(at_, golden_), EnvironmentError);
  EXPECT_EQ(ReadGolden(at_).pictures.views[1].name, "hand");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_ / "goldens"), {}), 1);
}

TEST_F(GoldenTest, NamesAMissingFile) {
  fs::remove(at_ / "hand_0004_depth.png");
  EXPECT_THAT(Refusal(), HasSubstr("hand_0004_depth.png"));
  fs::remove(at_ / kGoldenFile);
  EXPECT_THAT(Refusal(), HasSubstr("golden.yaml: cannot be read"));
}

TEST_F(GoldenTest, NamesADamagedPicture) {
  fs::resize_file(at_ / "hand.png", 60);
  EXPECT_THAT(Refusal(), HasSubstr("hand.png: not a"));
}

TEST_F(GoldenTest, NamesAPictureOfAnotherSize) {
  render::WritePng(at_ / "overview_0000.png", render::Image(32, 24));
  EXPECT_THAT(Refusal(), HasSubstr("overview_0000.png: is of 32 x 24 pixels"));
}

TEST_F(GoldenTest, NamesAStripOfAnotherNumberOfFrames) {
  render::WritePng(at_ / "overview.png", render::Image(512, 48));
  EXPECT_THAT(Refusal(), HasSubstr("overview.png: is not of the size that 5 frames make"));
}

TEST_F(GoldenTest, RefusesATextThatIsNoGolden) {
  const std::string good = test::ReadText(at_ / kGoldenFile);
  const std::pair<const char*, const char*> changes[] = {
      {"format: 1", "format: 2"},   {"frames: 5", "frames: 0"},    {"frames: 5", "frames: 4"},
      {"frames: 5", "frames: -5"},  {"interval_s", "interval"},    {"keys: [0, 4]", "keys: [0, 9]"},
      {"bodies:", "bodies: 3 #"},   {"states: \"", "states: \"x"}, {"views:", "views: ["},
      {"width: 64", "width: wide"},
  };
  for (const auto& [old, with] : changes) {
    Replace(old, with);
    EXPECT_THAT(Refusal(), HasSubstr("golden.yaml")) << with;
    std::ofstream(at_ / kGoldenFile) << good;
  }
  EXPECT_EQ(Refusal(), "");
}

}  // namespace
}  // namespace twin::golden
