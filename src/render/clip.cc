#include "twin/render/clip.h"

#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "render/frame_worker.h"
#include "twin/core/error.h"
#include "twin/render/frame_painter.h"
#include "twin/render/image.h"
#include "twin/render/video_writer.h"

namespace twin::render {
namespace {

VideoSettings MakeVideoSettings(const ClipSettings& settings, const ClipFrames& frames) {
  VideoSettings video;
  video.width = frames.width;
  video.height = frames.height;
  video.fps = frames.fps;
  video.crf = settings.crf;
  video.ffmpeg = settings.ffmpeg;
  return video;
}

/// Collects selected frames at half their size.
class SheetCollector {
 public:
  explicit SheetCollector(std::vector<std::size_t> frames) : frames_(std::move(frames)) {}

  void Add(std::size_t frame, const Image& image) {
    if (images_.size() < frames_.size() && frame == frames_[images_.size()]) {
      images_.push_back(HalveImage(image));
    }
  }
  [[nodiscard]] const std::vector<Image>& images() const noexcept { return images_; }

 private:
  std::vector<std::size_t> frames_;  ///< rising
  std::vector<Image> images_;
};

}  // namespace

ClipFrames FramesOf(const Film& film, const FilmSettings& settings) {
  const auto new_painter = [&film, &settings]() -> DrawFrame {
    // Shared only because std::function copies; it has one user.
    return [painter = std::make_shared<FramePainter>(film, settings)](std::size_t frame) {
      return painter->Paint(frame);
    };
  };
  return {.count = film.snapshots->size(),
          .fps = film.snapshots->fps(),
          .width = settings.render.width,
          .height = settings.render.height,
          .new_drawer = new_painter};
}

ClipStats RenderClip(const Film& film, const ClipSettings& settings, const ClipPaths& paths,
                     const Clock& clock, const ClipProgress& progress) {
  return RenderClip(FramesOf(film, settings.film), settings, paths, clock, progress);
}

ClipStats RenderClip(const ClipFrames& frames, const ClipSettings& settings, const ClipPaths& paths,
                     const Clock& clock, const ClipProgress& progress) {
  TWIN_CHECK(frames.count > 0);
  RequireInRange("video: sheet_pictures", settings.sheet_pictures, 1, 1000);
  const Time begin = clock.Now();
  std::optional<VideoWriter> video;
  if (!paths.video.empty()) {
    video.emplace(paths.video, MakeVideoSettings(settings, frames));
  }
  SheetCollector sheet(
      SpreadFrames(frames.count, static_cast<std::size_t>(settings.sheet_pictures)));
  FrameWorker worker(frames);
  for (std::size_t i = 0; i < frames.count; ++i) {
    const Image image = worker.Take();
    if (video) video->Write(image);
    sheet.Add(i, image);
    if (progress) progress(i + 1, frames.count);
  }
  if (video) video->Finish();
  if (!paths.contact_sheet.empty()) {
    WritePng(paths.contact_sheet, ComposeContactSheet(sheet.images(), settings.sheet));
  }
  return {frames.count, ToSeconds(clock.Now() - begin)};
}

}  // namespace twin::render
