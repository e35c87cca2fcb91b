#pragma once

#include <filesystem>

#include "twin/render/video_writer.h"

namespace twin::render {

/// Where a video is to be: a partial one beside it until it is whole.
class VideoTarget {
 public:
  /// Removes the partial pictures of an earlier run, and makes the folder of partial pictures.
  /// @throws InputError where a video cannot go: a folder where a file is to be, a file where a
  /// folder is to be, a folder that holds anything but the pictures of a video; EnvironmentError
  /// when a folder cannot be made.
  explicit VideoTarget(const std::filesystem::path& path);

  [[nodiscard]] VideoFormat format() const noexcept { return format_; }
  [[nodiscard]] const std::filesystem::path& partial() const noexcept { return partial_; }

  /// The partial video gets its name, in place of an older one.
  /// @throws EnvironmentError when the system refuses.
  void Publish() const;

 private:
  VideoFormat format_;
  std::filesystem::path path_;
  std::filesystem::path partial_;
};

}  // namespace twin::render
