// The formats without loss, and what a video may replace.

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdio.h>
#include <sys/file.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "support/temporary_folder.h"
#include "twin/core/error.h"
#include "twin/render/image.h"
#include "twin/render/video_writer.h"

namespace twin::render::video_formats_test {
namespace {

namespace fs = std::filesystem;

constexpr int kFrames = 60;
// Odd on purpose.
constexpr int kWidth = 61;
constexpr int kHeight = 47;

/// Noise, different in each frame and each channel.
Image Noise(int index) {
  Image image(kWidth, kHeight);
  std::uint32_t x = 2463534242U + static_cast<std::uint32_t>(index);
  for (std::uint8_t& byte : image.rgb) {
    x ^= x << 13U;
    x ^= x >> 17U;
    x ^= x << 5U;
    byte = static_cast<std::uint8_t>(x);
  }
  return image;
}

VideoSettings OddSettings() {
  VideoSettings settings;
  settings.width = kWidth;
  settings.height = kHeight;
  return settings;
}

void WriteVideo(const fs::path& path, int frames = kFrames) {
  VideoWriter video(path, OddSettings());
  for (int i = 0; i < frames; ++i) video.Write(Noise(i));
  video.Finish();
}

std::string Output(const std::string& command) {
  FILE* const pipe = popen(command.c_str(), "r");
  std::string text;
  for (int c = fgetc(pipe); c != EOF; c = fgetc(pipe)) text.push_back(static_cast<char>(c));
  pclose(pipe);
  return text;
}

std::string Count(const fs::path& path) {
  return Output(
      "ffprobe -v error -count_frames -show_entries stream=codec_name,nb_read_frames"
      " -of csv=p=0 '" +
      path.string() + "'");
}

std::string MessageOf(const fs::path& path, const VideoSettings& settings = OddSettings()) {
  try {
    const VideoWriter video(path, settings);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

/// Writes a video in a process that ends in the middle, as one that is killed; waits until ffmpeg,
/// which holds the lock on the partial one, is done with it.
void WriteAndDie(const fs::path& path) {
  const pid_t writer = fork();
  if (writer == 0) {
    VideoWriter video(path, OddSettings());
    for (int i = 0; i < kFrames; ++i) video.Write(Noise(i));
    _exit(0);
  }
  waitpid(writer, nullptr, 0);
  const int partial = open((path.string() + ".partial").c_str(), O_RDONLY);
  ASSERT_EQ(flock(partial, LOCK_EX), 0);
  close(partial);
}

TEST(VideoFormatTest, FollowsFromTheName) {
  EXPECT_EQ(FormatOf("out/a.mp4"), VideoFormat::kH264);
  EXPECT_EQ(FormatOf("out.d/a.mkv"), VideoFormat::kFfv1);
  EXPECT_EQ(FormatOf("out.d/frames"), VideoFormat::kPictures);
  EXPECT_EQ(FormatOf("out/frames.v2/"), VideoFormat::kPictures);
}

TEST(VideoFormatTest, NamesTheExtensionsThereAre) {
  const test::TemporaryFolder folder;
  EXPECT_THAT(MessageOf(folder / "a.avi"), testing::HasSubstr(".mp4 (H.264), .mkv (FFV1"));
  EXPECT_THROW(static_cast<void>(FormatOf("")), InputError);
}

TEST(VideoFormatTest, MatroskaHoldsEveryByte) {
  const test::TemporaryFolder folder;
  WriteVideo(folder / "a.mkv");
  EXPECT_EQ(Count(folder / "a.mkv"), "ffv1,60\n");
  const std::string rgb = Output("ffmpeg -v error -i '" + (folder / "a.mkv").string() +
                                 "' -f rawvideo -pix_fmt rgb24 -");
  ASSERT_EQ(rgb.size(), kFrames * Noise(0).rgb.size());
  for (const int frame : {0, 31, kFrames - 1}) {
    const auto& expected = Noise(frame).rgb;
    EXPECT_EQ(rgb.substr(static_cast<std::size_t>(frame) * expected.size(), expected.size()),
              std::string(expected.begin(), expected.end()));
  }
}

TEST(VideoFormatTest, FolderHoldsEveryByteUnderPaddedNames) {
  const test::TemporaryFolder folder;
  WriteVideo(folder / "frames", 12);
  for (const int frame : {0, 7, 11}) {
    char name[32];
    snprintf(name, sizeof name, "frames/frame_%06d.png", frame);
    EXPECT_EQ(ReadPng(folder / name), Noise(frame)) << name;
  }
  EXPECT_FALSE(fs::exists(folder / "frames/frame_000012.png"));
  EXPECT_FALSE(fs::exists(folder / "frames.partial"));
}

TEST(VideoFormatTest, PercentSignsInTheFoldersNameStay) {
  const test::TemporaryFolder folder;
  WriteVideo(folder / "100%d/", 2);
  EXPECT_TRUE(fs::exists(folder / "100%d/frame_000001.png"));
}

TEST(VideoFormatTest, SameFramesGiveTheSameBytes) {
  const test::TemporaryFolder folder;
  WriteVideo(folder / "a.mkv");
  WriteVideo(folder / "b.mkv");
  EXPECT_EQ(test::ReadText(folder / "a.mkv"), test::ReadText(folder / "b.mkv"));
  WriteVideo(folder / "a", 3);
  WriteVideo(folder / "b", 3);
  EXPECT_EQ(test::ReadText(folder / "a/frame_000002.png"),
            test::ReadText(folder / "b/frame_000002.png"));
}

TEST(VideoFormatTest, KilledMatroskaPlays) {
  const test::TemporaryFolder folder;
  WriteAndDie(folder / "a.mkv");
  EXPECT_FALSE(fs::exists(folder / "a.mkv"));
  EXPECT_EQ(Count(folder / "a.mkv.partial"), "ffv1,60\n");
}

TEST(VideoFormatTest, OddSizesAreForTheOthersNotForH264) {
  const test::TemporaryFolder folder;
  EXPECT_THAT(MessageOf(folder / "a.mp4"), testing::HasSubstr("61x47; H.264 needs an even"));
  EXPECT_FALSE(fs::exists(folder / "a.mp4.partial"));
}

TEST(VideoFormatTest, ReplacesAnOlderFolderOfPicturesWhole) {
  const test::TemporaryFolder folder;
  WriteVideo(folder / "frames", 9);
  WriteVideo(folder / "frames/", 2);
  EXPECT_TRUE(fs::exists(folder / "frames/frame_000001.png"));
  EXPECT_FALSE(fs::exists(folder / "frames/frame_000008.png"));
}

TEST(VideoFormatTest, TouchesNoFolderThatHoldsAnythingElse) {
  const test::TemporaryFolder folder;
  fs::create_directory(folder / "work");
  std::ofstream(folder / "work/thesis.txt") << "years";
  EXPECT_THAT(MessageOf(folder / "work"), testing::HasSubstr("holds thesis.txt"));
  EXPECT_EQ(test::ReadText(folder / "work/thesis.txt"), "years");
  EXPECT_FALSE(fs::exists(folder / "work.partial"));
}

TEST(VideoFormatTest, TakesNoFolderThatIsThereForTheNameOfANewOne) {
  for (const char* name : {".", "./", "..", "a/..", "/"}) {
    EXPECT_THROW(CheckVideoPath(name), InputError) << name;
  }
}

TEST(VideoFormatTest, PutsNoFolderInPlaceOfAFile) {
  const test::TemporaryFolder folder;
  std::ofstream(folder / "frames") << "a file";
  EXPECT_THAT(MessageOf(folder / "frames"), testing::HasSubstr("is a file"));
  EXPECT_EQ(test::ReadText(folder / "frames"), "a file");
}

TEST(VideoFormatTest, PutsNoFileInPlaceOfAFolder) {
  const test::TemporaryFolder folder;
  fs::create_directory(folder / "a.mkv");
  EXPECT_THAT(MessageOf(folder / "a.mkv"), testing::HasSubstr("is a folder"));
}

}  // namespace
}  // namespace twin::render::video_formats_test
