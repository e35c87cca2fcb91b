#include "twin/render/video_writer.h"

#include <fmt/format.h>

#include <system_error>
#include <utility>

#include "render/ffmpeg.h"
#include "twin/core/error.h"

namespace twin::render {
void VideoSettings::Validate(VideoFormat format) const {
  RequireInRange("video: width (pixels)", width, 16, 4096);
  RequireInRange("video: height (pixels)", height, 16, 4096);
  RequireInRange("video: fps", fps, 1, 240);
  RequireInRange("video: crf", crf, 0, 51);
  if (format == VideoFormat::kH264 && (width % 2 != 0 || height % 2 != 0)) {
    throw InputError(fmt::format(
        "video: the size is {}x{}; H.264 needs an even width and height (.mkv does not)", width,
        height));
  }
}

class VideoWriter::Encoder {
 public:
  Encoder(const std::filesystem::path& path, const VideoSettings& settings)
      : settings_(settings),
        target_(path),
        process_(settings.ffmpeg.string(),
                 FfmpegArguments(settings, target_.format(), target_.partial()), target_.lock(),
                 settings.timeout) {}

  void Write(const Image& image) {
    TWIN_CHECK(image.width == settings_.width && image.height == settings_.height);
    process_.Send(image.rgb);
  }

  void Finish() {
    process_.Finish();
    std::error_code error;
    if (std::filesystem::is_empty(target_.partial(), error)) {
      throw EnvironmentError(fmt::format(
          "video: ffmpeg ended well and wrote nothing to {}; see whether \"{}\" is ffmpeg",
          target_.partial().string(), settings_.ffmpeg.string()));
    }
    target_.Publish();
  }

 private:
  VideoSettings settings_;
  VideoTarget target_;
  FfmpegProcess process_;
};

VideoWriter::VideoWriter(const std::filesystem::path& path, const VideoSettings& settings) {
  settings.Validate(FormatOf(path));
  encoder_ = std::make_unique<Encoder>(path, settings);
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
