#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "twin/core/realtime.h"
#include "twin/core/time.h"
#include "twin/plant/truth_probe.h"
#include "twin/rt/scene_record.h"

namespace twin::render {

/// What a camera would have seen of a run: the scene at each frame.
class Snapshots {
 public:
  /// @param fps  frames per second of the run's time, in [1, 1000].
  Snapshots(int fps, std::size_t qpos_size) : fps_(fps), qpos_size_(qpos_size) {}

  /// Makes room for so many in all.
  void Reserve(std::size_t scenes) { scenes_.reserve(scenes); }
  /// @pre scene.positions == qpos_size().
  void Append(const rt::SceneRecord& scene);

  [[nodiscard]] int fps() const noexcept { return fps_; }
  [[nodiscard]] std::size_t qpos_size() const noexcept { return qpos_size_; }
  [[nodiscard]] std::size_t size() const noexcept { return scenes_.size(); }
  /// @returns the instant at which frame `i` was captured. @pre i < size(), as the following.
  [[nodiscard]] Time time(std::size_t i) const { return scenes_[i].at; }
  /// @returns the positions in frame `i`.
  [[nodiscard]] std::span<const double> qpos(std::size_t i) const { return scenes_[i].Positions(); }
  [[nodiscard]] const rt::SceneRecord& scene(std::size_t i) const { return scenes_[i]; }

 private:
  friend class SnapshotRecorder;

  int fps_;
  std::size_t qpos_size_;
  std::vector<rt::SceneRecord> scenes_;
};

/// Captures snapshots while a run goes on, into storage taken at construction: 1.6 kB a frame, all
/// of which a video that is drawn after the run needs; or only the last one.
///
/// Frame k is due at k / fps, counted from the first call. A call that comes at or after that
/// captures it; one that comes several frames late captures the same positions for each, so that
/// the clip keeps pace with the run.
///
/// Threads: the plant's thread. Real-time: Capture() is noexcept and allocates nothing.
class SnapshotRecorder {
 public:
  enum class Keep : std::uint8_t { kAll, kLast };

  /// @param duration  of the run; frames due later are not captured.
  /// @throws InputError when fps is outside [1, 1000], duration is negative, or the model has more
  /// positions than a scene's record holds.
  SnapshotRecorder(Duration duration, int fps, std::size_t qpos_size, Keep keep = Keep::kAll);

  /// Captures what is due at `now`; nearly free when nothing is. @pre probe has the qpos_size
  /// given. @returns how many frames that were; last() is each of them.
  std::size_t Capture(Time now, const plant::TruthProbe& probe) noexcept TWIN_REALTIME;

  /// The scene captured last. @pre there is one.
  [[nodiscard]] const rt::SceneRecord& last() const noexcept { return last_; }
  /// All that were captured; with Keep::kLast none.
  [[nodiscard]] const Snapshots& snapshots() const noexcept { return snapshots_; }

 private:
  [[nodiscard]] Time DueTime(std::size_t frame) const noexcept;

  Snapshots snapshots_;
  Keep keep_;
  std::size_t max_frames_;
  std::size_t frames_ = 0;  ///< captured
  rt::SceneRecord last_;
  Time start_{};
  Time next_due_{};
};

}  // namespace twin::render
