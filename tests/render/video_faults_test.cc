// What happens to a video when the world does not play along: the error says what and what to do,
// an older video stays, and nothing partial is passed off as whole.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/mount.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>

#include "support/temporary_folder.h"
#include "twin/core/error.h"
#include "twin/render/video_writer.h"

namespace twin::render::video_faults_test {
namespace {

namespace fs = std::filesystem;

/// Grey noise, which does not compress.
Image Noise(int index) {
  Image image(320, 240);
  std::uint32_t x = 88172645U + static_cast<std::uint32_t>(index);
  for (std::uint8_t& byte : image.rgb) {
    x = 1664525U * x + 1013904223U;
    byte = static_cast<std::uint8_t>(x >> 24U);
  }
  return image;
}

VideoSettings Settings() {
  VideoSettings settings;
  settings.width = 320;
  settings.height = 240;
  return settings;
}

/// Writes a video of two seconds. @returns what went wrong.
std::string FailureOf(const fs::path& path, const VideoSettings& settings = Settings()) {
  try {
    VideoWriter video(path, settings);
    for (int i = 0; i < 50; ++i) video.Write(Noise(i));
    video.Finish();
  } catch (const EnvironmentError& error) {
    return error.what();
  }
  return "no error";
}

/// A folder with an older video of each kind, whose partial one has no room: /dev/full.
class FullDiskTest : public testing::TestWithParam<std::string> {
 protected:
  FullDiskTest() : path_(folder_ / ("a" + GetParam())) {
    std::ofstream(path_) << "an older video";
    fs::path partial = path_;
    partial += ".partial";
    fs::create_symlink("/dev/full", partial);
  }

  test::TemporaryFolder folder_;
  fs::path path_;
};

TEST_P(FullDiskTest, IsReportedAndLeavesTheOlderVideo) {
  const std::string text = FailureOf(path_);
  EXPECT_THAT(text, testing::HasSubstr("No space left on device"));
  EXPECT_THAT(text, testing::HasSubstr("Make room on the disk"));
  EXPECT_EQ(test::ReadText(path_), "an older video");
  EXPECT_FALSE(fs::is_symlink(path_.string() + ".partial"));
}

INSTANTIATE_TEST_SUITE_P(Formats, FullDiskTest, testing::Values(".mp4", ".mkv"),
                         [](const auto& info) { return info.param.substr(1); });

/// A disk of 200 kB, where the system lets us have one.
class SmallDiskTest : public testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    fs::create_directory(folder_ / "disk");
    mounted_ = mount("tmpfs", (folder_ / "disk").c_str(), "tmpfs", 0, "size=200k") == 0;
    if (!mounted_) GTEST_SKIP() << "no disk may be mounted here: " << std::strerror(errno);
  }
  void TearDown() override {
    if (mounted_ && umount((folder_ / "disk").c_str()) != 0) ADD_FAILURE() << "still mounted";
  }

  test::TemporaryFolder folder_;
  bool mounted_ = false;
};

TEST_P(SmallDiskTest, ThatFillsUpIsReportedAndHoldsNoWholeVideo) {
  const fs::path path = folder_ / ("disk/a" + GetParam());
  const std::string text = FailureOf(path);
  EXPECT_THAT(text, testing::HasSubstr("No space left on device"));
  EXPECT_TRUE(fs::is_empty(folder_ / "disk"));
}

INSTANTIATE_TEST_SUITE_P(Formats, SmallDiskTest, testing::Values(".mp4", ".mkv", ""),
                         [](const auto& info) {
                           return info.param.empty() ? "folder" : info.param.substr(1);
                         });

class SecondWriterTest : public testing::TestWithParam<std::string> {};

TEST_P(SecondWriterTest, IsRefusedAndTheFirstIsWhole) {
  const test::TemporaryFolder folder;
  const fs::path path = folder / ("a" + GetParam());
  VideoWriter first(path, Settings());
  first.Write(Noise(0));
  EXPECT_THAT(FailureOf(path), testing::AllOf(testing::HasSubstr("another run writes"),
                                              testing::HasSubstr(path.string())));
  first.Write(Noise(1));
  first.Finish();
  EXPECT_EQ(FailureOf(path), "no error");  // it is free again
}

INSTANTIATE_TEST_SUITE_P(Formats, SecondWriterTest, testing::Values(".mp4", ".mkv", ""),
                         [](const auto& info) {
                           return info.param.empty() ? "folder" : info.param.substr(1);
                         });

TEST(VideoFaultsTest, APartialOneOfAnotherIsNotPassedOffAsOnesOwn) {
  const test::TemporaryFolder folder;
  const fs::path ffmpeg = folder / "ffmpeg.sh";
  std::ofstream(ffmpeg)
      << "#!/bin/sh\nfor out; do :; done\necho a video >\"${out#file:}\"\ncat >/dev/null\n";
  fs::permissions(ffmpeg, fs::perms::owner_all);
  VideoSettings settings = Settings();
  settings.ffmpeg = ffmpeg;
  VideoWriter video(folder / "a.mp4", settings);
  while (fs::file_size(folder / "a.mp4.partial") == 0) usleep(1000);
  fs::remove(folder / "a.mp4.partial");
  std::ofstream(folder / "a.mp4.partial") << "of another";
  EXPECT_THROW(video.Finish(), EnvironmentError);
  EXPECT_FALSE(fs::exists(folder / "a.mp4"));
  EXPECT_EQ(test::ReadText(folder / "a.mp4.partial"), "of another");
}

TEST(VideoFaultsTest, AnFfmpegWithoutTheEncoderIsNamed) {
  const test::TemporaryFolder folder;
  const fs::path ffmpeg = folder / "ffmpeg.sh";
  std::ofstream(ffmpeg) << "#!/bin/sh\necho \"Unknown encoder 'libx264'\" >&2\nexit 1\n";
  fs::permissions(ffmpeg, fs::perms::owner_all);
  VideoSettings settings = Settings();
  settings.ffmpeg = ffmpeg;
  const std::string text = FailureOf(folder / "a.mp4", settings);
  EXPECT_THAT(text, testing::HasSubstr("Unknown encoder 'libx264'"));
  EXPECT_THAT(text, testing::HasSubstr("Debian's package ffmpeg has it"));
  EXPECT_FALSE(fs::exists(folder / "a.mp4"));
}

TEST(VideoFaultsTest, AnFfmpegThatDoesNothingIsEnded) {
  const test::TemporaryFolder folder;
  const fs::path ffmpeg = folder / "ffmpeg.sh";
  VideoSettings settings = Settings();
  settings.ffmpeg = ffmpeg;
  settings.timeout = std::chrono::milliseconds(100);
  for (const char* does : {"exec sleep 1000", "cat >/dev/null; exec sleep 1000"}) {
    std::ofstream(ffmpeg) << "#!/bin/sh\necho waiting >&2\n" << does << "\n";
    fs::permissions(ffmpeg, fs::perms::owner_all);
    const std::string text = FailureOf(folder / "a.mp4", settings);
    EXPECT_THAT(text, testing::HasSubstr("did nothing for 0.1 s, and was ended")) << does;
    EXPECT_FALSE(fs::exists(folder / "a.mp4"));
    EXPECT_FALSE(fs::exists(folder / "a.mp4.partial"));
  }
}

TEST(VideoFaultsTest, AnFfmpegThatWritesNothingMadeNoVideo) {
  const test::TemporaryFolder folder;
  const fs::path ffmpeg = folder / "ffmpeg.sh";
  std::ofstream(ffmpeg) << "#!/bin/sh\ncat >/dev/null\n";
  fs::permissions(ffmpeg, fs::perms::owner_all);
  VideoSettings settings = Settings();
  settings.ffmpeg = ffmpeg;
  for (const std::string name : {"a.mp4", "a.mkv", "frames/"}) {
    EXPECT_THAT(FailureOf(folder / name, settings), testing::HasSubstr("wrote nothing")) << name;
    EXPECT_FALSE(fs::exists(folder / name)) << name;
  }
}

TEST(VideoFaultsTest, AFolderThatIsNotThereIsNamed) {
  const test::TemporaryFolder folder;
  for (const std::string name : {"missing/a.mp4", "missing/a.mkv", "missing/frames/"}) {
    const std::string text = FailureOf(folder / name);
    EXPECT_THAT(text, testing::HasSubstr("missing/")) << name;
    EXPECT_THAT(text, testing::HasSubstr("No such file or directory")) << name;
  }
  EXPECT_FALSE(fs::exists(folder / "missing"));
}

TEST(VideoFaultsTest, AFileInTheFoldersPlaceIsNamed) {
  const test::TemporaryFolder folder;
  std::ofstream(folder / "file") << "a file";
  EXPECT_THAT(FailureOf(folder / "file/a.mp4"), testing::HasSubstr("Not a directory"));
  EXPECT_EQ(test::ReadText(folder / "file"), "a file");
}

}  // namespace
}  // namespace twin::render::video_faults_test
