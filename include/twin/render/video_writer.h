#pragma once

#include <filesystem>
#include <memory>

#include "twin/render/image.h"

namespace twin::render {

struct VideoSettings {
  int width = 640;   ///< pixels, even, in [16, 4096]
  int height = 480;  ///< pixels, even, in [16, 4096]
  int fps = 25;      ///< frames per second, in [1, 240]
  int crf = 20;      ///< x264's constant rate factor, in [0, 51]; smaller is better and larger
  std::filesystem::path ffmpeg = "ffmpeg";  ///< program; without a slash it is looked up in PATH

  /// @throws InputError naming field, value and range.
  void Validate() const;
};

/// Encodes pictures to H.264 in MP4 by an ffmpeg process.
///
/// One encoder thread and bit-exact flags: the same pictures give the same file, with the same
/// build of ffmpeg. The file is in fragments of two seconds: `<path>.partial` can be played up to
/// the last of them whatever ends the run, and a run that dies leaves ffmpeg to complete it.
///
/// ffmpeg has a process group of its own (an interrupt from the terminal does not reach it), reads
/// from a socket (its death is an error here, never a SIGPIPE) and ends when the writer is gone.
///
/// Threads: one thread. Not real-time: Write() waits while ffmpeg is behind.
class VideoWriter {
 public:
  /// @param path  of the finished video; it appears, replacing an older one, with Finish().
  /// @throws InputError for settings out of range; EnvironmentError when ffmpeg cannot be started
  /// (says what to install).
  VideoWriter(std::filesystem::path path, const VideoSettings& settings);

  /// Without Finish(), ends ffmpeg and leaves `<path>.partial`.
  ~VideoWriter();
  VideoWriter(VideoWriter&&) noexcept;
  VideoWriter& operator=(VideoWriter&&) = delete;

  /// Appends a frame. @pre image has the settings' size; Finish() was not called.
  /// @throws EnvironmentError when ffmpeg has died, with its last lines.
  void Write(const Image& image);

  /// Ends the video and gives the file its name.
  /// @throws EnvironmentError when ffmpeg failed (a full disk, say), with its last lines; the
  /// `.partial` file then stays.
  void Finish();

 private:
  class Encoder;
  std::unique_ptr<Encoder> encoder_;
};

}  // namespace twin::render
