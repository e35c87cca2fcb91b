#pragma once

#include <string>

#include "twin/render/image.h"

namespace twin::render {

/// Encodes pictures as JPEG with libjpeg-turbo, chroma at half the resolution. Threads: one.
class JpegEncoder {
 public:
  /// @param quality  in [1, 100]. @throws EnvironmentError if the library gives no encoder.
  explicit JpegEncoder(int quality);
  ~JpegEncoder();
  JpegEncoder(const JpegEncoder&) = delete;
  JpegEncoder& operator=(const JpegEncoder&) = delete;

  /// @returns the file's bytes. @pre the picture is not empty. @throws EnvironmentError with the
  /// library's reason.
  [[nodiscard]] std::string Encode(const Image& image);

 private:
  void* handle_;
  const int quality_;
};

}  // namespace twin::render
