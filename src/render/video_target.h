#pragma once

#include <filesystem>

#include "twin/record/partial_output.h"
#include "twin/render/video_writer.h"

namespace twin::render {

/// Path of a video: a partial output beside it until it is complete.
class VideoTarget {
 public:
  /// Creates and locks the partial output, and removes an earlier run's pictures from it.
  /// @throws InputError as CheckVideoPath(); EnvironmentError as record::PartialOutput.
  explicit VideoTarget(const std::filesystem::path& path);
  /// Removes the partial output unless it was published.
  ~VideoTarget();
  VideoTarget(const VideoTarget&) = delete;
  VideoTarget& operator=(const VideoTarget&) = delete;

  [[nodiscard]] VideoFormat format() const noexcept { return format_; }
  [[nodiscard]] const std::filesystem::path& partial() const noexcept { return output_.partial(); }
  /// @returns its lock, for the process that writes it.
  [[nodiscard]] int lock() const noexcept { return output_.lock(); }

  /// Renames the partial video to its path, replacing an older one.
  /// @throws EnvironmentError if the system refuses.
  void Publish();

 private:
  VideoFormat format_;
  std::filesystem::path path_;
  record::PartialOutput output_;
};

}  // namespace twin::render
