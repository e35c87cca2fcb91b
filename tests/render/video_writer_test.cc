#include "twin/render/video_writer.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdio.h>
#include <sys/file.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>
#include <string>

#include "support/temporary_folder.h"
#include "twin/core/error.h"

namespace twin::render::video_writer_test {
namespace {

constexpr int kFrames = 60;

VideoSettings SmallSettings() {
  VideoSettings settings;
  settings.width = 96;
  settings.height = 64;
  settings.fps = 25;
  return settings;
}

/// A bright square that wanders over a grey ramp.
Image Frame(int index) {
  Image image(96, 64);
  for (int row = 0; row < image.height; ++row) {
    for (int column = 0; column < image.width; ++column) {
      const bool square = column >= index && column < index + 16 && row >= 20 && row < 36;
      const auto grey = static_cast<std::uint8_t>(column + row);
      const Rgb colour = square ? Rgb{230, 120, 20} : Rgb{grey, grey, grey};
      std::copy(colour.begin(), colour.end(),
                image.rgb.begin() + static_cast<std::ptrdiff_t>(image.Offset(column, row)));
    }
  }
  return image;
}

void WriteVideo(const std::filesystem::path& path) {
  VideoWriter video(path, SmallSettings());
  for (int i = 0; i < kFrames; ++i) video.Write(Frame(i));
  video.Finish();
}

/// @returns what a command prints.
std::string Output(const std::string& command) {
  FILE* const pipe = popen(command.c_str(), "r");
  std::string text;
  for (int c = fgetc(pipe); c != EOF; c = fgetc(pipe)) text.push_back(static_cast<char>(c));
  pclose(pipe);
  return text;
}

std::string Probe(const std::filesystem::path& path, const std::string& entries) {
  return Output("ffprobe -v error -count_frames -select_streams v -show_entries stream=" + entries +
                " -of csv=p=0 '" + path.string() + "'");
}

/// A stand-in for ffmpeg.
std::filesystem::path Script(const test::TemporaryFolder& folder, const std::string& body) {
  std::filesystem::path path = folder / "ffmpeg.sh";
  std::ofstream(path) << "#!/bin/sh\n" << body << "\n";
  std::filesystem::permissions(path, std::filesystem::perms::owner_all);
  return path;
}

/// Writes frames until the writer throws. @returns its text.
std::string FailureOf(const std::filesystem::path& path, const VideoSettings& settings) {
  try {
    VideoWriter video(path, settings);
    for (int i = 0; i < 2000; ++i) video.Write(Frame(i % 80));
    video.Finish();
  } catch (const EnvironmentError& e) {
    return e.what();
  }
  return "no error";
}

/// Writes a video in a process that ends in the middle, as one that is killed; waits until ffmpeg,
/// which holds the lock on the partial one, is done with it.
void WriteAndDie(const std::filesystem::path& path) {
  const pid_t writer = fork();
  if (writer == 0) {
    VideoWriter video(path, SmallSettings());
    for (int i = 0; i < kFrames; ++i) video.Write(Frame(i));
    _exit(0);
  }
  waitpid(writer, nullptr, 0);
  const int partial = open((path.string() + ".partial").c_str(), O_RDONLY);
  ASSERT_EQ(flock(partial, LOCK_EX), 0);
  close(partial);
}

TEST(VideoWriterTest, WritesEveryFrameAsH264InBt709) {
  const test::TemporaryFolder folder;
  WriteVideo(folder / "a.mp4");
  EXPECT_EQ(Probe(folder / "a.mp4",
                  "codec_name,width,height,pix_fmt,color_space,r_frame_rate,nb_read_frames"),
            "h264,96,64,yuv420p,bt709,25/1,60\n");
}

TEST(VideoWriterTest, WritesTheSameBytesForTheSameFrames) {
  const test::TemporaryFolder folder;
  WriteVideo(folder / "a.mp4");
  WriteVideo(folder / "b.mp4");
  EXPECT_GT(test::ReadText(folder / "a.mp4").size(), 1000U);
  EXPECT_EQ(test::ReadText(folder / "a.mp4"), test::ReadText(folder / "b.mp4"));
}

TEST(VideoWriterTest, KeepsColours) {
  const test::TemporaryFolder folder;
  WriteVideo(folder / "a.mp4");
  const std::string rgb = Output("ffmpeg -v error -i '" + (folder / "a.mp4").string() +
                                 "' -f rawvideo -pix_fmt rgb24 -frames:v 1 -");
  const Image first = Frame(0);
  ASSERT_EQ(rgb.size(), first.rgb.size());
  for (const auto& [column, row] : {std::pair{8, 28}, {60, 10}, {80, 60}}) {
    for (std::size_t c = 0; c < 3; ++c) {
      const auto got = static_cast<std::uint8_t>(rgb[first.Offset(column, row) + c]);
      EXPECT_NEAR(got, first.at(column, row)[c], 8) << column << ", " << row;
    }
  }
}

TEST(VideoWriterTest, IsPartialUntilItIsFinished) {
  const test::TemporaryFolder folder;
  VideoWriter video(folder / "a.mp4", SmallSettings());
  video.Write(Frame(0));
  EXPECT_FALSE(std::filesystem::exists(folder / "a.mp4"));
  video.Finish();
  EXPECT_TRUE(std::filesystem::exists(folder / "a.mp4"));
  EXPECT_FALSE(std::filesystem::exists(folder / "a.mp4.partial"));
}

TEST(VideoWriterTest, LeavesNothingWhenItIsAbandoned) {
  const test::TemporaryFolder folder;
  for (const char* name : {"a.mp4", "a.mkv", "frames/"}) {
    VideoWriter video(folder / name, SmallSettings());
    video.Write(Frame(0));
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(VideoWriterTest, LeavesAPlayablePartialFileWhenItIsKilled) {
  const test::TemporaryFolder folder;
  WriteAndDie(folder / "a.mp4");
  EXPECT_FALSE(std::filesystem::exists(folder / "a.mp4"));
  EXPECT_EQ(Probe(folder / "a.mp4.partial", "nb_read_frames"), "60\n");
}

TEST(VideoWriterTest, WritesFragmentsThatPlayWithoutTheRestOfTheFile) {
  const test::TemporaryFolder folder;
  WriteVideo(folder / "a.mp4");
  std::string bytes = test::ReadText(folder / "a.mp4");
  const std::size_t second_fragment = bytes.rfind("moof");  // frames 50 to 59
  ASSERT_NE(second_fragment, std::string::npos);
  std::ofstream(folder / "cut.mp4", std::ios::binary) << bytes.substr(0, second_fragment - 4);
  EXPECT_EQ(Probe(folder / "cut.mp4", "nb_read_frames"), "50\n");
}

TEST(VideoWriterTest, SaysWhatToInstallWhenThereIsNoFfmpeg) {
  const test::TemporaryFolder folder;
  VideoSettings settings = SmallSettings();
  settings.ffmpeg = "no-such-ffmpeg";
  const std::string text = FailureOf(folder / "a.mp4", settings);
  EXPECT_THAT(text, testing::HasSubstr("\"no-such-ffmpeg\""));
  EXPECT_THAT(text, testing::HasSubstr("apt-get install ffmpeg"));
}

TEST(VideoWriterTest, PassesOnTheLastLinesOfAnFfmpegThatDiesInTheMiddle) {
  const test::TemporaryFolder folder;
  VideoSettings settings = SmallSettings();
  settings.ffmpeg =
      Script(folder, "head -c 100000 >/dev/null; echo 'No space left on device' >&2; exit 1");
  const std::string text = FailureOf(folder / "a.mp4", settings);
  EXPECT_THAT(text, testing::HasSubstr("No space left on device"));
  EXPECT_THAT(text, testing::HasSubstr("exit code 1"));
}

TEST(VideoWriterTest, ReportsTheSignalThatEndedFfmpeg) {
  const test::TemporaryFolder folder;
  VideoSettings settings = SmallSettings();
  settings.ffmpeg = Script(folder, "head -c 100000 >/dev/null; kill -9 $$");
  EXPECT_THAT(FailureOf(folder / "a.mp4", settings), testing::HasSubstr("signal 9"));
}

TEST(VideoWriterTest, ReportsAFailureThatShowsOnlyAtTheEnd) {
  const test::TemporaryFolder folder;
  VideoSettings settings = SmallSettings();
  settings.ffmpeg = Script(folder, "cat >/dev/null; echo 'cannot write the index' >&2; exit 3");
  const std::string text = FailureOf(folder / "a.mp4", settings);
  EXPECT_THAT(text, testing::HasSubstr("cannot write the index"));
  EXPECT_THAT(text, testing::HasSubstr("exit code 3"));
}

TEST(VideoWriterTest, ReportsAFolderThatIsNotThere) {
  const test::TemporaryFolder folder;
  EXPECT_THAT(FailureOf(folder / "missing/a.mp4", SmallSettings()),
              testing::HasSubstr("No such file or directory"));
}

TEST(VideoWriterTest, RefusesSettingsOutOfRange) {
  VideoSettings settings = SmallSettings();
  settings.fps = 0;
  EXPECT_THROW(settings.Validate(VideoFormat::kH264), InputError);
  settings = SmallSettings();
  settings.crf = 52;
  EXPECT_THROW(settings.Validate(VideoFormat::kH264), InputError);
}

}  // namespace
}  // namespace twin::render::video_writer_test
