#include "twin/render/snapshots.h"

#include <fmt/format.h>

#include "twin/core/check.h"
#include "twin/core/error.h"
#include "twin/plant/scene_capture.h"

namespace twin::render {
namespace {

constexpr std::int64_t kNanosecondsPerSecond = 1'000'000'000;

Snapshots MakeSnapshots(Duration duration, int fps, std::size_t qpos_size) {
  if (fps < 1 || fps > 1000) {
    throw InputError(fmt::format("video: fps is {}; it must be in [1, 1000]", fps));
  }
  if (duration < Duration::zero()) {
    throw InputError(
        fmt::format("video: the run's duration is {} ns; it must be >= 0", duration.count()));
  }
  if (qpos_size > rt::SceneRecord::kMostPositions) {
    throw InputError(fmt::format(
        "video: the scene has {} positions; a picture takes {} at most. Leave objects out of it",
        qpos_size, rt::SceneRecord::kMostPositions));
  }
  return Snapshots(fps, qpos_size);
}

}  // namespace

void Snapshots::Append(const rt::SceneRecord& scene) {
  TWIN_CHECK(scene.positions == qpos_size_);
  scenes_.push_back(scene);
}

SnapshotRecorder::SnapshotRecorder(Duration duration, int fps, std::size_t qpos_size, Keep keep)
    : snapshots_(MakeSnapshots(duration, fps, qpos_size)),
      keep_(keep),
      max_frames_(static_cast<std::size_t>(duration.count() * fps / kNanosecondsPerSecond) + 1) {
  if (keep_ == Keep::kAll) snapshots_.scenes_.reserve(max_frames_);
}

std::size_t SnapshotRecorder::Capture(Time now, const plant::TruthProbe& probe) noexcept {
  if (frames_ == 0) {
    start_ = now;
    next_due_ = now;
  }
  if (next_due_ > now || frames_ >= max_frames_) return 0;
  plant::CaptureScene(now, probe, last_);
  const std::size_t before = frames_;
  while (next_due_ <= now && frames_ < max_frames_) {
    if (keep_ == Keep::kAll) snapshots_.scenes_.push_back(last_);  // within the reserved capacity
    next_due_ = DueTime(++frames_);
  }
  return frames_ - before;
}

Time SnapshotRecorder::DueTime(std::size_t frame) const noexcept {
  return start_ +
         Duration(static_cast<std::int64_t>(frame) * kNanosecondsPerSecond / snapshots_.fps_);
}

}  // namespace twin::render
