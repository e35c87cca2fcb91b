#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "twin/core/time.h"
#include "twin/plant/contact_watch.h"
#include "twin/plant/truth_probe.h"
#include "twin/record/cycle_record.h"
#include "twin/record/log_split.h"
#include "twin/record/recorder.h"
#include "twin/record/scene_record.h"
#include "twin/render/snapshots.h"
#include "twin/scenario/robot_data.h"
#include "twin/scenario/scenario.h"

namespace twin::run {

/// Passes a run's records on to log, camera and contact watch, those of them that were added before
/// the robot's first cycle.
///
/// Threads: Put() as RecordSink's; the others from the run's thread while no motion runs.
class RunRecords final : public record::RecordSink {
 public:
  /// @throws EnvironmentError as record::Recorder.
  void Log(const std::filesystem::path& path, const record::RunInfo& run,
           record::FullRing full_ring, const record::LogSplit& split = {});
  /// Records the scene at each frame of the video, for the log too.
  /// @param keep   kLast: for the log alone, without a film. @param truth  must outlive this,
  /// as WatchContacts(). @throws as render::SnapshotRecorder.
  void Film(const plant::TruthProbe& truth, Duration duration, int fps,
            render::SnapshotRecorder::Keep keep = render::SnapshotRecorder::Keep::kAll);
  /// Whether a scene record holds all positions.
  [[nodiscard]] static bool CanFilm(const plant::TruthProbe& truth) noexcept {
    return truth.qpos_size() <= record::SceneRecord::kMostPositions;
  }
  /// Also notes in the log, as events "contact", what the arm touched when the robot raised errors.
  void WatchContacts(const plant::TruthProbe& truth);

  void Put(const record::CycleRecord& record) noexcept TWIN_REALTIME override;
  void Put(const record::TickRecord& record) noexcept TWIN_REALTIME override;

  /// Adds an event to the log alone. Threads: in lockstep the robot's, in real time one for all.
  void Event(Time at, std::string_view kind, std::string_view text) noexcept TWIN_REALTIME;
  /// For RunHooks::event: events for log and film; empty without both.
  [[nodiscard]] std::function<void(Time, std::string_view, std::string_view)> Events();

  /// Adds a plan to log and film; after the run, before Finish().
  void Add(record::PlanRecord plan);

  /// After the run: completes the log. @returns the number of records that were dropped.
  /// @throws EnvironmentError as record::Recorder::Finish.
  std::uint64_t Finish();

  /// After a run that threw: leaves the log partial.
  void Abandon() { log_.reset(); }

  /// During a run: why the log cannot be written any more; empty: it can.
  [[nodiscard]] std::string LogFailure() const { return log_ ? log_->Failure() : std::string(); }
  /// Whether the log could not be completed; its partial file can be read.
  [[nodiscard]] bool log_failed() const noexcept { return log_failed_; }

  /// Null without a camera.
  [[nodiscard]] const render::Snapshots* snapshots() const noexcept {
    return camera_ ? &camera_->snapshots() : nullptr;
  }
  /// Whether there is at least one frame.
  [[nodiscard]] bool was_filmed() const noexcept {
    return camera_ && camera_->snapshots().size() > 0;
  }
  /// For the film, beside snapshots().
  [[nodiscard]] const std::vector<record::PlanRecord>& plans() const noexcept { return plans_; }
  [[nodiscard]] const std::vector<record::EventRecord>& events() const noexcept { return events_; }
  /// Of a robot that MuJoCo simulates.
  [[nodiscard]] const std::optional<plant::ContactWatch>& contacts() const noexcept {
    return contacts_;
  }

 private:
  /// Records the scenes that are due, for film and log.
  void TakeScenes(Time now) noexcept TWIN_REALTIME;

  std::optional<record::Recorder> log_;
  bool log_failed_ = false;
  std::optional<render::SnapshotRecorder> camera_;
  std::optional<plant::ContactWatch> contacts_;
  bool had_error_ = false;                    ///< in the last cycle
  const plant::TruthProbe* truth_ = nullptr;  ///< set with camera_
  std::vector<record::PlanRecord> plans_;
  std::vector<record::EventRecord> events_;
};

/// The description of a run in its log.
[[nodiscard]] record::RunInfo InfoOf(const scenario::Scenario& scenario,
                                     const scenario::RobotData& robot);

}  // namespace twin::run
