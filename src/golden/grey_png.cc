#include "golden/golden_files.h"

#include <fmt/format.h>
#include <png.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <vector>

#include "twin/core/error.h"

namespace twin::golden {
namespace {

constexpr std::uint8_t kNoBody = 255;
constexpr std::uint16_t kMostDepth = 65535;

png_image EmptyPng(png_uint_32 format) {
  png_image png;
  std::memset(&png, 0, sizeof png);
  png.version = PNG_IMAGE_VERSION;
  png.format = format;
  return png;
}

template <typename Pixel>
void Write(const std::filesystem::path& path, int width, int height, png_uint_32 format,
           const std::vector<Pixel>& pixels) {
  png_image png = EmptyPng(format);
  png.width = static_cast<png_uint_32>(width);
  png.height = static_cast<png_uint_32>(height);
  if (png_image_write_to_file(&png, path.c_str(), /*convert_to_8bit=*/0, pixels.data(),
                              /*row_stride=*/0, nullptr) == 0) {
    throw EnvironmentError(fmt::format("{}: cannot be written ({})", path.string(), png.message));
  }
}

/// @param sort  the expected kind of file, for the message.
template <typename Pixel>
std::vector<Pixel> Read(const std::filesystem::path& path, png_uint_32 format,
                        std::string_view sort, int& width, int& height) {
  png_image png = EmptyPng(0);
  if (png_image_begin_read_from_file(&png, path.c_str()) == 0) {
    throw InputError(fmt::format("{}: not a readable PNG ({})", path.string(), png.message));
  }
  if (png.format != format) {
    png_image_free(&png);
    throw InputError(fmt::format("{}: not {}", path.string(), sort));
  }
  width = static_cast<int>(png.width);
  height = static_cast<int>(png.height);
  std::vector<Pixel> pixels(std::size_t{png.width} * png.height);
  if (png_image_finish_read(&png, nullptr, pixels.data(), /*row_stride=*/0, nullptr) == 0) {
    throw InputError(fmt::format("{}: not a whole PNG ({})", path.string(), png.message));
  }
  return pixels;
}

std::uint16_t InUnits(float depth_m) {
  if (depth_m == render::DepthImage::kBackground) return 0;
  const double units = std::round(static_cast<double>(depth_m) / kDepthUnit);
  return static_cast<std::uint16_t>(std::clamp(units, 1.0, double{kMostDepth}));
}

float InMetres(std::uint16_t units) {
  return static_cast<float>(units * kDepthUnit);
}

}  // namespace

render::DepthImage RoundedDepths(const render::DepthImage& image) {
  render::DepthImage rounded = image;
  for (float& depth : rounded.depth_m) depth = InMetres(InUnits(depth));
  return rounded;
}

void WriteDepths(const std::filesystem::path& path, const render::DepthImage& image) {
  std::vector<std::uint16_t> pixels(image.depth_m.size());
  std::transform(image.depth_m.begin(), image.depth_m.end(), pixels.begin(), InUnits);
  Write(path, image.width, image.height, PNG_FORMAT_LINEAR_Y, pixels);
}

render::DepthImage ReadDepths(const std::filesystem::path& path) {
  render::DepthImage image;
  const auto pixels = Read<std::uint16_t>(path, PNG_FORMAT_LINEAR_Y, "16-bit grey, as depths are",
                                          image.width, image.height);
  image.depth_m.resize(pixels.size());
  std::transform(pixels.begin(), pixels.end(), image.depth_m.begin(), InMetres);
  return image;
}

void WriteBodies(const std::filesystem::path& path, const render::SegmentationImage& image) {
  std::vector<std::uint8_t> pixels(image.body.size());
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    TWIN_CHECK(image.body[i] < kNoBody);
    pixels[i] = image.body[i] < 0 ? kNoBody : static_cast<std::uint8_t>(image.body[i]);
  }
  Write(path, image.width, image.height, PNG_FORMAT_GRAY, pixels);
}

render::SegmentationImage ReadBodies(const std::filesystem::path& path) {
  render::SegmentationImage image;
  const auto pixels = Read<std::uint8_t>(path, PNG_FORMAT_GRAY, "8-bit grey, as bodies are",
                                         image.width, image.height);
  image.body.resize(pixels.size());
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    image.body[i] =
        pixels[i] == kNoBody ? render::SegmentationImage::kBackground : std::int32_t{pixels[i]};
  }
  return image;
}

}  // namespace twin::golden
