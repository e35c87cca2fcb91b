#include "twin/render/snapshots.h"

#include <fmt/format.h>

#include "twin/core/check.h"
#include "twin/core/error.h"

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
  return Snapshots(fps, qpos_size);
}

}  // namespace

SnapshotRecorder::SnapshotRecorder(Duration duration, int fps, std::size_t qpos_size)
    : snapshots_(MakeSnapshots(duration, fps, qpos_size)),
      max_frames_(static_cast<std::size_t>(duration.count() * fps / kNanosecondsPerSecond) + 1) {
  snapshots_.times_.reserve(max_frames_);
  snapshots_.qpos_.reserve(max_frames_ * qpos_size);
}

void SnapshotRecorder::Capture(Time now, const plant::TruthProbe& probe) noexcept {
  if (snapshots_.times_.empty()) {
    start_ = now;
    next_due_ = now;
  }
  while (next_due_ <= now && snapshots_.times_.size() < max_frames_) {
    // Within the capacity reserved: neither call allocates.
    const std::size_t begin = snapshots_.qpos_.size();
    snapshots_.qpos_.resize(begin + snapshots_.qpos_size_);
    probe.CopyQpos(std::span(snapshots_.qpos_).subspan(begin));
    snapshots_.times_.push_back(now);
    next_due_ = DueTime(snapshots_.times_.size());
  }
}

Time SnapshotRecorder::DueTime(std::size_t frame) const noexcept {
  return start_ +
         Duration(static_cast<std::int64_t>(frame) * kNanosecondsPerSecond / snapshots_.fps_);
}

}  // namespace twin::render
