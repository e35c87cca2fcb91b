#include "twin/render/image.h"

#include <fmt/format.h>
#include <png.h>

#include <cerrno>
#include <cstring>
#include <fstream>

#include "twin/core/error.h"
#include "twin/record/partial_output.h"

namespace twin::render {
namespace {

png_image EmptyPng() {
  png_image png;
  std::memset(&png, 0, sizeof png);
  png.version = PNG_IMAGE_VERSION;
  png.format = PNG_FORMAT_RGB;
  return png;
}

}  // namespace

std::vector<char> EncodePng(const Image& image) {
  TWIN_CHECK(image.width > 0 && image.height > 0 && image.rgb.size() == 3 * image.Pixels());
  png_image png = EmptyPng();
  png.width = static_cast<png_uint_32>(image.width);
  png.height = static_cast<png_uint_32>(image.height);
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(png);
  std::vector<char> bytes(size);
  const int ok = png_image_write_to_memory(&png, bytes.data(), &size, /*convert_to_8bit=*/0,
                                           image.rgb.data(), /*row_stride=*/0, nullptr);
  TWIN_CHECK(ok != 0);
  bytes.resize(size);
  return bytes;
}

void WritePng(const std::filesystem::path& path, const Image& image) {
  const std::vector<char> bytes = EncodePng(image);
  record::PartialOutput output(path, record::PartialOutput::Kind::kFile);
  errno = 0;
  std::ofstream file(output.partial(), std::ios::binary | std::ios::trunc);
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  file.close();
  if (!file) {
    throw EnvironmentError(fmt::format(
        "{}: cannot be written ({}). Choose an output folder that exists, may be written and has "
        "room",
        output.partial().string(), std::strerror(errno)));
  }
  output.Publish();
}

Image ReadPng(const std::filesystem::path& path) {
  png_image png = EmptyPng();
  if (png_image_begin_read_from_file(&png, path.c_str()) == 0) {
    throw InputError(fmt::format("{}: not a readable PNG ({})", path.string(), png.message));
  }
  png.format = PNG_FORMAT_RGB;
  Image image(static_cast<int>(png.width), static_cast<int>(png.height));
  const png_color black{0, 0, 0};
  if (png_image_finish_read(&png, &black, image.rgb.data(), /*row_stride=*/0, nullptr) == 0) {
    throw InputError(fmt::format("{}: not a whole PNG ({})", path.string(), png.message));
  }
  return image;
}

}  // namespace twin::render
