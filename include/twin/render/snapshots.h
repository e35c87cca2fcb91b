#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "twin/core/realtime.h"
#include "twin/core/time.h"
#include "twin/plant/truth_probe.h"

namespace twin::render {

/// What a camera would have seen of a run: one set of generalised positions per frame.
class Snapshots {
 public:
  /// @param fps  frames per second of the run's time, in [1, 1000].
  Snapshots(int fps, std::size_t qpos_size) : fps_(fps), qpos_size_(qpos_size) {}

  [[nodiscard]] int fps() const noexcept { return fps_; }
  [[nodiscard]] std::size_t qpos_size() const noexcept { return qpos_size_; }
  [[nodiscard]] std::size_t size() const noexcept { return times_.size(); }
  /// @returns the instant at which frame `i` was captured. @pre i < size()
  [[nodiscard]] Time time(std::size_t i) const { return times_[i]; }
  /// @returns the positions in frame `i`. @pre i < size()
  [[nodiscard]] std::span<const double> qpos(std::size_t i) const {
    return {qpos_.data() + i * qpos_size_, qpos_size_};
  }

 private:
  friend class SnapshotRecorder;

  int fps_;
  std::size_t qpos_size_;
  std::vector<Time> times_;
  std::vector<double> qpos_;
};

/// Captures snapshots while a run goes on, into storage taken at construction.
///
/// Frame k is due at k / fps, counted from the first call. A call that comes at or after that
/// captures it; one that comes several frames late captures the same positions for each, so that
/// the clip keeps pace with the run.
///
/// Threads: the plant's thread. Real-time: Capture() is noexcept and allocates nothing.
class SnapshotRecorder {
 public:
  /// @param duration  of the run; frames due later are not captured.
  /// @throws InputError when fps is outside [1, 1000] or duration is negative.
  SnapshotRecorder(Duration duration, int fps, std::size_t qpos_size);

  /// Captures what is due at `now`; nearly free when nothing is. @pre probe has the qpos_size
  /// given.
  void Capture(Time now, const plant::TruthProbe& probe) noexcept TWIN_REALTIME;

  [[nodiscard]] const Snapshots& snapshots() const noexcept { return snapshots_; }

 private:
  [[nodiscard]] Time DueTime(std::size_t frame) const noexcept;

  Snapshots snapshots_;
  std::size_t max_frames_;
  Time start_{};
  Time next_due_{};
};

}  // namespace twin::render
