#include "twin/golden/golden.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <fstream>
#include <functional>
#include <optional>
#include <thread>

#include "golden/made_up_golden.h"
#include "support/temporary_folder.h"
#include "twin/core/error.h"
#include "twin/golden/approval.h"
#include "twin/render/image.h"

namespace twin::golden::golden_golden_test {
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

  [[noreturn]] void WriteForever() noexcept {
    while (true) {
      ++golden_.states[0];
      WriteGolden(at_, golden_);
    }
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
  EXPECT_EQ(read.approvals[0].reason, golden_.approvals[0].reason);
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

TEST_F(GoldenTest, IsThereWhenTheExchangeWasKilledBetweenItsSteps) {
  fs::rename(at_, folder_ / "goldens/case.replaced");
  fs::create_directories(folder_ / "goldens/case.partial");
  EXPECT_TRUE(HasGolden(at_));
  EXPECT_EQ(ReadGolden(at_).states, golden_.states);
}

TEST_F(GoldenTest, IsReplacedAfterTheExchangeWasKilledBetweenItsSteps) {
  fs::rename(at_, folder_ / "goldens/case.replaced");
  fs::create_directories(folder_ / "goldens/case.partial");
  golden_.states = {8};
  WriteGolden(at_, golden_);
  EXPECT_EQ(ReadGolden(at_).states, golden_.states);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_ / "goldens"), {}), 1);
}

TEST_F(GoldenTest, IsNotThereWhenNothingWasApproved) {
  EXPECT_FALSE(HasGolden(folder_ / "goldens/other"));
}

// However it is killed: while one process writes in a loop, a whole golden can be read, old or new.
TEST_F(GoldenTest, IsWholeWheneverTheWriterIsKilled) {
  for (int kill_after_ms = 1; kill_after_ms <= 20; ++kill_after_ms) {
    const pid_t writer = ::fork();
    if (writer == 0) WriteForever();
    std::this_thread::sleep_for(std::chrono::milliseconds(kill_after_ms));
    ::kill(writer, SIGKILL);
    ::waitpid(writer, nullptr, 0);
    EXPECT_NO_THROW(static_cast<void>(ReadGolden(at_))) << kill_after_ms;
  }
}

TEST_F(GoldenTest, RefusesToReplaceWhatItDidNotWrite) {
  std::ofstream(at_ / "notes.txt") << "mine";
  golden_.states = {8};
  try {
    WriteGolden(at_, golden_);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("case/notes.txt"));
  }
  EXPECT_EQ(test::ReadText(at_ / "notes.txt"), "mine");
  EXPECT_EQ(ReadGolden(at_).states, std::vector<std::uint64_t>{7});
}

TEST_F(GoldenTest, RefusesToReplaceAFolderThatIsNoGolden) {
  fs::create_directories(folder_ / "mine/video");
  EXPECT_THROW(WriteGolden(folder_ / "mine", golden_), InputError);
  EXPECT_TRUE(fs::exists(folder_ / "mine/video"));
}

TEST_F(GoldenTest, IsApprovedByOneAtATime) {
  std::optional<GoldensLock> first(at_.parent_path());
  EXPECT_THROW(GoldensLock(at_.parent_path()), EnvironmentError);
  first.reset();
  EXPECT_NO_THROW(GoldensLock(at_.parent_path()));
}

TEST_F(GoldenTest, StaysAsItWasOnAFullDiskAndSaysWhatToDo) {
  // A limit on the size of files stands for the full disk.
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const rlimit small{20, before.rlim_max};
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  std::string refusal;
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
  try {
    WriteGolden(at_, golden_);
  } catch (const EnvironmentError& error) {
    refusal = error.what();
  }
  ::setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
  EXPECT_THAT(refusal, HasSubstr("overview.png: cannot be written (File too large)"));
  EXPECT_THAT(refusal, HasSubstr("make room, and approve again"));
  EXPECT_EQ(ReadGolden(at_).states, golden_.states);
}

TEST_F(GoldenTest, NamesAMissingFile) {
  fs::remove(at_ / "hand_0004_depth.png");
  EXPECT_THAT(Refusal(), HasSubstr("hand_0004_depth.png"));
  fs::remove(at_ / kGoldenFile);
  EXPECT_THAT(Refusal(), HasSubstr("golden.yaml: cannot be read (No such file or directory)"));
}

TEST_F(GoldenTest, SaysHowToGetBackWhatIsMissing) {
  fs::remove(at_ / "hand.png");
  EXPECT_THAT(Refusal(), HasSubstr("git checkout -- " + at_.string()));
}

TEST_F(GoldenTest, SaysWhyItsTextCannotBeRead) {
  fs::remove(at_ / kGoldenFile);
  fs::create_directory(at_ / kGoldenFile);
  EXPECT_THAT(Refusal(), HasSubstr("golden.yaml: cannot be read (Is a directory)"));
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
}  // namespace twin::golden::golden_golden_test
