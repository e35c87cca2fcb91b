#include "twin/render/video_writer.h"

#include <fmt/format.h>

#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "render/ffmpeg_process.h"
#include "twin/core/check.h"
#include "twin/core/error.h"

namespace twin::render {
namespace {

/// A key frame, and with it a fragment that can be played, every so often.
constexpr int kSecondsPerFragment = 2;

/// Exact arithmetic, at full chroma resolution.
constexpr const char* kScale =
    "scale=out_color_matrix=bt709:out_range=tv:"
    "flags=bicubic+accurate_rnd+full_chroma_int+bitexact";

void CheckRange(const char* field, int value, int low, int high) {
  if (value < low || value > high) {
    throw InputError(
        fmt::format("video: {} is {}; it must be in [{}, {}]", field, value, low, high));
  }
}

std::vector<std::string> EncoderArguments(const VideoSettings& settings,
                                          const std::filesystem::path& output) {
  return {"-hide_banner", "-nostdin", "-loglevel", "error",
          // In: raw pictures. The queue makes ffmpeg read ahead while it encodes.
          "-f", "rawvideo", "-pix_fmt", "rgb24", "-video_size",
          fmt::format("{}x{}", settings.width, settings.height), "-framerate",
          std::to_string(settings.fps), "-thread_queue_size", "4", "-i", "pipe:0",
          // To BT.709 and tagged as such, or players guess the colours by the picture's size.
          "-filter_threads", "1", "-vf", kScale, "-colorspace", "bt709", "-color_primaries",
          "bt709", "-color_trc", "bt709",
          // One thread and no version strings or dates: same pictures, same bytes.
          "-c:v", "libx264", "-preset", "veryfast", "-crf", std::to_string(settings.crf),
          "-pix_fmt", "yuv420p", "-threads", "1", "-g",
          std::to_string(kSecondsPerFragment * settings.fps), "-flags:v", "+bitexact", "-fflags",
          "+bitexact", "-map_metadata", "-1",
          // In fragments, so that a file cut short can be played; flushed as they come.
          "-movflags", "+frag_keyframe+empty_moov+default_base_moof", "-flush_packets", "1", "-f",
          "mp4", "-y", "file:" + output.string()};
}

}  // namespace

void VideoSettings::Validate() const {
  CheckRange("width (pixels)", width, 16, 4096);
  CheckRange("height (pixels)", height, 16, 4096);
  CheckRange("fps", fps, 1, 240);
  CheckRange("crf", crf, 0, 51);
  if (width % 2 != 0 || height % 2 != 0) {
    throw InputError(fmt::format("video: the size is {}x{}; H.264 needs an even width and height",
                                 width, height));
  }
}

class VideoWriter::Encoder {
 public:
  Encoder(std::filesystem::path path, const VideoSettings& settings)
      : path_(std::move(path)),
        settings_(settings),
        process_(settings.ffmpeg.string(), EncoderArguments(settings, PartialPath())) {}

  void Write(const Image& image) {
    TWIN_CHECK(image.width == settings_.width && image.height == settings_.height);
    process_.Send(image.rgb);
  }

  void Finish() {
    process_.Finish();
    std::error_code error;
    std::filesystem::rename(PartialPath(), path_, error);
    if (error) {
      throw EnvironmentError(fmt::format("video: {} cannot be given its name ({})",
                                         PartialPath().string(), error.message()));
    }
  }

 private:
  [[nodiscard]] std::filesystem::path PartialPath() const {
    std::filesystem::path partial = path_;
    partial += ".partial";
    return partial;
  }

  std::filesystem::path path_;
  VideoSettings settings_;
  FfmpegProcess process_;
};

VideoWriter::VideoWriter(std::filesystem::path path, const VideoSettings& settings) {
  settings.Validate();
  encoder_ = std::make_unique<Encoder>(std::move(path), settings);
}

VideoWriter::~VideoWriter() = default;
VideoWriter::VideoWriter(VideoWriter&&) noexcept = default;

void VideoWriter::Write(const Image& image) {
  encoder_->Write(image);
}

void VideoWriter::Finish() {
  encoder_->Finish();
}

}  // namespace twin::render
