#include "twin/render/clip.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "render/frame_worker.h"
#include "twin/core/check.h"
#include "twin/core/error.h"
#include "twin/render/png.h"
#include "twin/render/video_writer.h"

namespace twin::render {
namespace {

void CheckRange(const char* field, int value, int low, int high) {
  if (value < low || value > high) {
    throw InputError(
        fmt::format("video: {} is {}; it must be in [{}, {}]", field, value, low, high));
  }
}

VideoSettings MakeVideoSettings(const ClipSettings& settings, int fps) {
  VideoSettings video;
  video.width = settings.film.render.width;
  video.height = settings.film.render.height;
  video.fps = fps;
  video.crf = settings.crf;
  video.ffmpeg = settings.ffmpeg;
  return video;
}

/// Collects evenly spaced frames, at half their size.
class SheetCollector {
 public:
  SheetCollector(std::size_t frames, std::size_t pictures)
      : frames_(frames), pictures_(std::min(frames, pictures)) {}

  void Add(std::size_t frame, const Image& image) {
    if (images_.size() < pictures_ && frame == FrameOf(images_.size())) {
      images_.push_back(HalveImage(image));
    }
  }
  [[nodiscard]] const std::vector<Image>& images() const noexcept { return images_; }

 private:
  [[nodiscard]] std::size_t FrameOf(std::size_t picture) const noexcept {
    return pictures_ == 1 ? 0 : picture * (frames_ - 1) / (pictures_ - 1);
  }

  std::size_t frames_;
  std::size_t pictures_;
  std::vector<Image> images_;
};

std::vector<std::unique_ptr<FrameWorker>> StartWorkers(const Film& film,
                                                       const ClipSettings& settings) {
  const std::size_t count =
      std::min(film.snapshots->size(), static_cast<std::size_t>(settings.render_threads));
  std::vector<std::unique_ptr<FrameWorker>> workers;
  for (std::size_t i = 0; i < count; ++i) {
    workers.push_back(std::make_unique<FrameWorker>(film, settings.film, i, count));
  }
  return workers;
}

}  // namespace

ClipStats RenderClip(const Film& film, const ClipSettings& settings, const ClipPaths& paths,
                     const Clock& clock, const ClipProgress& progress) {
  const Snapshots& snapshots = *film.snapshots;
  TWIN_CHECK(snapshots.size() > 0);
  CheckRange("sheet_pictures", settings.sheet_pictures, 1, 1000);
  CheckRange("render_threads", settings.render_threads, 1, 16);
  const Time begin = clock.Now();
  std::optional<VideoWriter> video;
  if (!paths.video.empty()) {
    video.emplace(paths.video, MakeVideoSettings(settings, snapshots.fps()));
  }
  SheetCollector sheet(snapshots.size(), static_cast<std::size_t>(settings.sheet_pictures));
  const auto workers = StartWorkers(film, settings);
  for (std::size_t i = 0; i < snapshots.size(); ++i) {
    const Image image = workers[i % workers.size()]->Take();
    if (video) video->Write(image);
    sheet.Add(i, image);
    if (progress) progress(i + 1, snapshots.size());
  }
  if (video) video->Finish();
  if (!paths.contact_sheet.empty()) {
    WritePng(paths.contact_sheet, ComposeContactSheet(sheet.images(), settings.sheet));
  }
  return {snapshots.size(), ToSeconds(clock.Now() - begin)};
}

}  // namespace twin::render
