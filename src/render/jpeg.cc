#include "twin/render/jpeg.h"

#include <turbojpeg.h>

#include <fmt/format.h>

#include "twin/core/error.h"

namespace twin::render {

JpegEncoder::JpegEncoder(int quality) : handle_(tjInitCompress()), quality_(quality) {
  if (handle_ == nullptr) {
    throw EnvironmentError(fmt::format("no picture can be encoded as JPEG: {}", tjGetErrorStr()));
  }
}

JpegEncoder::~JpegEncoder() {
  tjDestroy(handle_);
}

std::string JpegEncoder::Encode(const Image& image) {
  TWIN_CHECK(!image.rgb.empty());
  std::string bytes(tjBufSize(image.width, image.height, TJSAMP_420), '\0');
  auto* out = reinterpret_cast<unsigned char*>(bytes.data());
  auto size = static_cast<unsigned long>(bytes.size());
  if (tjCompress2(handle_, image.rgb.data(), image.width, 0, image.height, TJPF_RGB, &out, &size,
                  TJSAMP_420, quality_, TJFLAG_NOREALLOC) != 0) {
    throw EnvironmentError(
        fmt::format("a picture cannot be encoded as JPEG: {}", tjGetErrorStr2(handle_)));
  }
  bytes.resize(size);
  return bytes;
}

}  // namespace twin::render
