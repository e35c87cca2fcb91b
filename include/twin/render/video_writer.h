#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>

#include "twin/core/time.h"
#include "twin/render/image.h"

namespace twin::render {

/// Encoding of a video.
enum class VideoFormat : std::uint8_t {
  kH264,      ///< `.mp4`: H.264, small, widely supported; lossy
  kFfv1,      ///< `.mkv`: FFV1 in Matroska, lossless
  kPictures,  ///< a folder: frame_000000.png and so on, lossless
};

struct VideoSettings {
  int width = 640;   ///< pixels, in [16, 4096]; even for H.264
  int height = 480;  ///< pixels, as width
  int fps = 25;      ///< frames per second, in [1, 240]
  int crf = 20;      ///< x264's constant rate factor, in [0, 51]; smaller is better and larger
  std::filesystem::path ffmpeg = "ffmpeg";  ///< program; looked up in PATH if it has no slash
  /// Timeout for ffmpeg to take a frame, and to end after the last one; it is then killed.
  Duration timeout = std::chrono::seconds(60);

  /// @throws InputError naming field, value and range.
  void Validate(VideoFormat format) const;
};

/// @returns the format for a path: `.mp4` or `.mkv`; a folder if it ends with a slash or has no
/// extension.
/// @throws InputError for another extension, or no name (lists the known ones).
[[nodiscard]] VideoFormat FormatOf(const std::filesystem::path& path);

/// Checks a video's path before anything is written.
/// @throws InputError for another extension, a folder at a file's path, a file at a folder's path,
/// a folder with other contents than a video's pictures, and for `.`, `..` and `/`.
void CheckVideoPath(const std::filesystem::path& path);

/// Encodes pictures with an ffmpeg process.
///
/// One encoder thread and bit-exact flags: the same pictures give the same files, with the same
/// build of ffmpeg. Incomplete videos are playable, even if the run is killed: files as
/// `<path>.partial` in steps of two seconds (MP4: fragments, Matroska: clusters), folders as
/// `<folder>.partial` picture by picture. ffmpeg completes them after the run's death. The partial
/// output stays locked until both processes have released it.
///
/// ffmpeg has its own process group (an interrupt from the terminal does not reach it), reads from
/// a socket (its death is an error here, never a SIGPIPE) and ends when the writer is gone.
///
/// Threads: one thread. Not real-time: Write() waits while ffmpeg lags.
class VideoWriter {
 public:
  /// @param path  of the finished video, see FormatOf(); Finish() creates it, replacing an older
  /// one. A folder may only hold the pictures of an older video.
  /// @throws InputError for settings out of range, an odd size for H.264, and as CheckVideoPath();
  /// EnvironmentError if another process writes this video, its folder is not writable, or ffmpeg
  /// cannot be started (names what to install).
  VideoWriter(const std::filesystem::path& path, const VideoSettings& settings);

  /// Without Finish(): kills ffmpeg and removes the partial output.
  ~VideoWriter();
  VideoWriter(VideoWriter&&) noexcept;
  VideoWriter& operator=(VideoWriter&&) = delete;

  /// Appends a frame. @pre image has the settings' size; Finish() was not called.
  /// @throws EnvironmentError if ffmpeg has died, with its last lines.
  void Write(const Image& image);

  /// Completes the video and renames it to its path.
  /// @throws EnvironmentError if ffmpeg failed (on a full disk, for example), with its last lines;
  /// an older video is then kept.
  void Finish();

 private:
  class Encoder;
  std::unique_ptr<Encoder> encoder_;
};

}  // namespace twin::render
