#pragma once

#include <filesystem>

#include "twin/record/partial_output.h"
#include "twin/render/video_writer.h"

namespace twin::render {

/// Where a video is to be: a partial one beside it until it is whole.
class VideoTarget {
 public:
  /// Makes the partial one, which nobody else then writes, without the pictures of an earlier run.
  /// @throws InputError as CheckVideoPath(); EnvironmentError as record::PartialOutput.
  explicit VideoTarget(const std::filesystem::path& path);
  /// Removes the partial one, unless it got its name.
  ~VideoTarget();
  VideoTarget(const VideoTarget&) = delete;
  VideoTarget& operator=(const VideoTarget&) = delete;

  [[nodiscard]] VideoFormat format() const noexcept { return format_; }
  [[nodiscard]] const std::filesystem::path& partial() const noexcept { return output_.partial(); }
  /// @returns the lock on it, for the process that writes it.
  [[nodiscard]] int lock() const noexcept { return output_.lock(); }

  /// The partial video gets its name, in place of an older one.
  /// @throws EnvironmentError when the system refuses.
  void Publish();

 private:
  VideoFormat format_;
  std::filesystem::path path_;
  record::PartialOutput output_;
};

}  // namespace twin::render
