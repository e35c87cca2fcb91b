#include "twin/render/image.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <unistd.h>

#include <fstream>

#include "support/temporary_folder.h"
#include "twin/core/error.h"

namespace twin::render::png_test {
namespace {

/// Every value of every channel, in no order.
Image Pattern(int width, int height) {
  Image image(width, height);
  for (std::size_t i = 0; i < image.rgb.size(); ++i) {
    image.rgb[i] = static_cast<std::uint8_t>((i * 2654435761U) >> 13U);
  }
  return image;
}

TEST(PngTest, ReadsBackWhatWasWritten) {
  const test::TemporaryFolder folder;
  const Image image = Pattern(37, 23);
  WritePng(folder / "a.png", image);
  EXPECT_EQ(ReadPng(folder / "a.png"), image);
}

TEST(PngTest, WritesTheSameBytesForTheSameImage) {
  const test::TemporaryFolder folder;
  WritePng(folder / "a.png", Pattern(64, 48));
  WritePng(folder / "b.png", Pattern(64, 48));
  EXPECT_EQ(test::ReadText(folder / "a.png"), test::ReadText(folder / "b.png"));
}

TEST(PngTest, LeavesNoPartialFileBehind) {
  const test::TemporaryFolder folder;
  WritePng(folder / "a.png", Pattern(8, 8));
  EXPECT_FALSE(std::filesystem::exists(folder / "a.png.partial"));
}

TEST(PngTest, LeavesNoPartialFileWhereAFolderIsInTheWay) {
  const test::TemporaryFolder folder;
  std::filesystem::create_directories(folder / "a.png/mine");
  EXPECT_THROW(WritePng(folder / "a.png", Pattern(8, 8)), EnvironmentError);
  EXPECT_FALSE(std::filesystem::exists(folder / "a.png.partial"));
}

TEST(PngTest, LeavesNoPartialFileOnAFullDisk) {
  const test::TemporaryFolder folder;
  std::filesystem::create_symlink("/dev/full", folder / "a.png.partial");
  EXPECT_THROW(WritePng(folder / "a.png", Pattern(64, 48)), EnvironmentError);
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(PngTest, RefusesWhatAnotherWrites) {
  const test::TemporaryFolder folder;
  std::ofstream(folder / "a.png.partial") << "half a picture";
  const int other = open((folder / "a.png.partial").c_str(), O_RDONLY);
  ASSERT_EQ(flock(other, LOCK_EX), 0);
  EXPECT_THROW(WritePng(folder / "a.png", Pattern(8, 8)), EnvironmentError);
  EXPECT_EQ(test::ReadText(folder / "a.png.partial"), "half a picture");
  close(other);
}

TEST(PngTest, NamesTheFileThatCannotBeWritten) {
  const test::TemporaryFolder folder;
  try {
    WritePng(folder / "missing/a.png", Pattern(8, 8));
    FAIL() << "nothing was thrown";
  } catch (const EnvironmentError& e) {
    EXPECT_THAT(e.what(), testing::HasSubstr("missing/a.png.partial"));
    EXPECT_THAT(e.what(), testing::HasSubstr("No such file"));
  }
}

TEST(PngTest, RefusesWhatIsNoWholePng) {
  const test::TemporaryFolder folder;
  EXPECT_THROW((void)ReadPng(folder / "missing.png"), InputError);
  WritePng(folder / "a.png", Pattern(64, 48));
  const std::string bytes = test::ReadText(folder / "a.png");
  std::ofstream(folder / "cut.png", std::ios::binary) << bytes.substr(0, bytes.size() / 2);
  EXPECT_THROW((void)ReadPng(folder / "cut.png"), InputError);
  std::ofstream(folder / "text.png") << "not a picture";
  EXPECT_THROW((void)ReadPng(folder / "text.png"), InputError);
}

}  // namespace
}  // namespace twin::render::png_test
