#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "twin/core/realtime.h"
#include "twin/core/time.h"
#include "twin/plant/truth_probe.h"
#include "twin/record/scene_record.h"

namespace twin::render {

/// The scene of a run at each video frame.
class Snapshots {
 public:
  /// @param fps  frames per second of the run's time, in [1, 1000].
  Snapshots(int fps, std::size_t qpos_size) : fps_(fps), qpos_size_(qpos_size) {}

  /// Reserves memory for this number of scenes.
  void Reserve(std::size_t scenes) { scenes_.reserve(scenes); }
  /// @pre scene.positions == qpos_size().
  void Append(const record::SceneRecord& scene);

  [[nodiscard]] int fps() const noexcept { return fps_; }
  [[nodiscard]] std::size_t qpos_size() const noexcept { return qpos_size_; }
  [[nodiscard]] std::size_t size() const noexcept { return scenes_.size(); }
  /// @returns the instant at which frame `i` was captured. @pre here and below: i < size().
  [[nodiscard]] Time time(std::size_t i) const { return scenes_[i].at; }
  /// @returns the positions in frame `i`.
  [[nodiscard]] std::span<const double> qpos(std::size_t i) const { return scenes_[i].Positions(); }
  [[nodiscard]] const record::SceneRecord& scene(std::size_t i) const { return scenes_[i]; }

 private:
  friend class SnapshotRecorder;

  int fps_;
  std::size_t qpos_size_;
  std::vector<record::SceneRecord> scenes_;
};

/// Captures snapshots during a run into storage allocated at construction: 1.6 kB per frame; all of
/// them for a video drawn after the run, or only the last one.
///
/// Frame k is due at k / fps after the first call. The first call at or after that time captures
/// it. A call that is several frames late captures the same positions for each, so that the clip
/// keeps pace with the run.
///
/// Threads: the plant's thread. Real-time: Capture() is noexcept and does not allocate.
class SnapshotRecorder {
 public:
  enum class Keep : std::uint8_t { kAll, kLast };

  /// @param duration  of the run; frames due later are not captured.
  /// @throws InputError if fps is outside [1, 1000], duration is negative, or the model has more
  /// positions than a scene record holds.
  SnapshotRecorder(Duration duration, int fps, std::size_t qpos_size, Keep keep = Keep::kAll);

  /// Captures the frames due at `now`; almost free if none is. @pre probe has the given qpos_size.
  /// @returns the number of frames captured; last() is each of them.
  std::size_t Capture(Time now, const plant::TruthProbe& probe) noexcept TWIN_REALTIME;

  /// The last captured scene. @pre there is one.
  [[nodiscard]] const record::SceneRecord& last() const noexcept { return last_; }
  /// All captured scenes; none with Keep::kLast.
  [[nodiscard]] const Snapshots& snapshots() const noexcept { return snapshots_; }

 private:
  [[nodiscard]] Time DueTime(std::size_t frame) const noexcept;

  Snapshots snapshots_;
  Keep keep_;
  std::size_t max_frames_;
  std::size_t frames_ = 0;  ///< captured so far
  record::SceneRecord last_;
  Time start_{};
  Time next_due_{};
};

}  // namespace twin::render
