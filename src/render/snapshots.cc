#include "twin/render/snapshots.h"

#include <fmt/format.h>

#include "twin/core/error.h"
#include "twin/plant/observers.h"

namespace twin::render {
namespace {

constexpr std::int64_t kNanosecondsPerSecond = 1'000'000'000;

Snapshots MakeSnapshots(Duration duration, int fps, std::size_t qpos_size) {
  RequireInRange("video: fps", fps, 1, 1000);
  if (duration < Duration::zero()) {
    throw InputError(
        fmt::format("video: the run's duration is {} ns; it must be >= 0", duration.count()));
  }
  if (qpos_size > record::SceneRecord::kMostPositions) {
    throw InputError(fmt::format(
        "video: the scene has {} positions; a picture takes {} at most. Leave objects out of it",
        qpos_size, record::SceneRecord::kMostPositions));
  }
  return Snapshots(fps, qpos_size);
}

}  // namespace

void Snapshots::Append(const record::SceneRecord& scene) {
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
