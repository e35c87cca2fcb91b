#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>

#include "twin/core/time.h"
#include "twin/render/image.h"

namespace twin::render {

/// What pictures are encoded to.
enum class VideoFormat : std::uint8_t {
  kH264,      ///< `.mp4`: H.264, small, as every player shows it; with loss
  kFfv1,      ///< `.mkv`: FFV1 in Matroska, every byte of every picture as it was
  kPictures,  ///< a folder: frame_000000.png and so on, every byte too
};

struct VideoSettings {
  int width = 640;   ///< pixels, in [16, 4096]; even for H.264
  int height = 480;  ///< pixels, as width
  int fps = 25;      ///< frames per second, in [1, 240]
  int crf = 20;      ///< x264's constant rate factor, in [0, 51]; smaller is better and larger
  std::filesystem::path ffmpeg = "ffmpeg";  ///< program; without a slash it is looked up in PATH
  /// How long ffmpeg may take no frame, and take to end after the last one; it is then ended.
  Duration timeout = std::chrono::seconds(60);

  /// @throws InputError naming field, value and range.
  void Validate(VideoFormat format) const;
};

/// @returns the format that a path's name asks for: by `.mp4` or `.mkv`; a folder when it ends with
/// a slash or has no extension.
/// @throws InputError for another extension, or no name (says which there are).
[[nodiscard]] VideoFormat FormatOf(const std::filesystem::path& path);

/// Whether a video may be called so, for who wants to know before there is anything to write.
/// @throws InputError for another extension, a folder where a file is to be, a file where a folder
/// is to be, a folder that holds anything but the pictures of a video, and for `.`, `..` and `/`.
void CheckVideoPath(const std::filesystem::path& path);

/// Encodes pictures by an ffmpeg process.
///
/// One encoder thread and bit-exact flags: the same pictures give the same files, with the same
/// build of ffmpeg. Both kinds of file can be played while they are made, whatever kills the
/// run: `<path>.partial` in steps of two seconds (MP4: fragments, Matroska: clusters), of
/// `<folder>.partial` every picture; and a run that dies leaves ffmpeg to complete them. The
/// partial one is locked until both are done with it.
///
/// ffmpeg has a process group of its own (an interrupt from the terminal does not reach it), reads
/// from a socket (its death is an error here, never a SIGPIPE) and ends when the writer is gone.
///
/// Threads: one thread. Not real-time: Write() waits while ffmpeg is behind.
class VideoWriter {
 public:
  /// @param path  of the finished video, see FormatOf(); it appears, replacing an older one, with
  /// Finish(). A folder may only hold the pictures of an older video.
  /// @throws InputError for settings out of range, an odd size for H.264, and as CheckVideoPath();
  /// EnvironmentError when another writes a video of this name, its folder cannot be written to, or
  /// ffmpeg cannot be started (says what to install).
  VideoWriter(const std::filesystem::path& path, const VideoSettings& settings);

  /// Without Finish(), ends ffmpeg and removes what is partial.
  ~VideoWriter();
  VideoWriter(VideoWriter&&) noexcept;
  VideoWriter& operator=(VideoWriter&&) = delete;

  /// Appends a frame. @pre image has the settings' size; Finish() was not called.
  /// @throws EnvironmentError when ffmpeg has died, with its last lines.
  void Write(const Image& image);

  /// Ends the video and gives it its name.
  /// @throws EnvironmentError when ffmpeg failed (a full disk, say), with its last lines; an older
  /// video then stays.
  void Finish();

 private:
  class Encoder;
  std::unique_ptr<Encoder> encoder_;
};

}  // namespace twin::render
