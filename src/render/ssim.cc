#include "twin/render/image_operations.h"

#include <fmt/format.h>
#include <stdlib.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <string>
#include <system_error>

#include "render/ffmpeg.h"
#include "twin/core/error.h"
#include "twin/core/quantity.h"

namespace twin::render {
namespace {

/// Temporary file for ffmpeg's measurements; removed on destruction.
class StatsFile {
 public:
  StatsFile() : path_(std::filesystem::temp_directory_path() / "panda-twin-ssim-XXXXXX") {
    std::string pattern = path_.string();
    const int descriptor = ::mkstemp(pattern.data());
    if (descriptor < 0) {
      throw EnvironmentError(fmt::format("{}: cannot be made ({}); ssim needs a temporary file",
                                         pattern, std::strerror(errno)));
    }
    ::close(descriptor);
    path_ = pattern;
  }
  ~StatsFile() {
    std::error_code ignored;
    std::filesystem::remove(path_, ignored);
  }
  StatsFile(const StatsFile&) = delete;
  StatsFile& operator=(const StatsFile&) = delete;

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// ffmpeg gets one video whose frames have the expected picture above the actual one, and splits
/// them: no second input is needed.
std::vector<std::string> ArgumentsFor(const Image& one, const std::filesystem::path& stats) {
  return {"-nostdin",
          "-hide_banner",
          "-loglevel",
          "error",
          "-f",
          "rawvideo",
          "-pixel_format",
          "rgb24",
          "-video_size",
          fmt::format("{}x{}", one.width, 2 * one.height),
          "-framerate",
          "25",
          "-i",
          "pipe:0",
          "-lavfi",
          fmt::format("format=gbrp,split[a][b];[a]crop={0}:{1}:0:0[x];[b]crop={0}:{1}:0:{1}[y];"
                      "[x][y]ssim=stats_file={2}",
                      one.width, one.height, stats.string()),
          "-f",
          "null",
          "-"};
}

/// Parses the values of lines such as "n:1 R:0.99 G:0.99 B:0.99 All:0.99 (20.1)".
std::vector<double> ReadStats(const std::filesystem::path& path, std::size_t wanted) {
  constexpr std::string_view kKey = "All:";
  std::ifstream file(path);
  std::vector<double> values;
  for (std::string line; std::getline(file, line);) {
    const std::size_t at = line.find(kKey);
    if (at == std::string::npos) continue;
    const std::size_t begin = at + kKey.size();
    values.push_back(ParseNumber(line.substr(begin, line.find(' ', begin) - begin)));
  }
  if (values.size() != wanted) {
    throw EnvironmentError(
        fmt::format("ffmpeg's filter ssim gave {} values for {} pictures; this build of ffmpeg is "
                    "not of use here (Debian's is)",
                    values.size(), wanted));
  }
  return values;
}

}  // namespace

std::vector<double> MeasureSsim(std::span<const Image> expected, std::span<const Image> actual,
                                const std::filesystem::path& ffmpeg) {
  TWIN_CHECK(expected.size() == actual.size());
  if (expected.empty()) return {};
  const StatsFile stats;
  FfmpegProcess process(ffmpeg.string(), ArgumentsFor(expected[0], stats.path()));
  for (std::size_t i = 0; i < expected.size(); ++i) {
    for (const Image* image : {&expected[i], &actual[i]}) {
      TWIN_CHECK(image->width == expected[0].width && image->height == expected[0].height);
      process.Send(image->rgb);
    }
  }
  process.Finish();
  return ReadStats(stats.path(), expected.size());
}

}  // namespace twin::render
