#pragma once

#include <atomic>
#include <cstdint>
#include <optional>

#include "twin/core/clock.h"
#include "twin/core/joint_vector.h"
#include "twin/core/mobile_base.h"
#include "twin/core/modes.h"
#include "twin/core/realtime.h"
#include "twin/core/robot_errors.h"
#include "twin/core/time.h"
#include "twin/record/cycle_record.h"
#include "twin/record/scene_record.h"
#include "twin/rt/latest_value.h"

namespace twin::plant {
class TruthProbe;
}  // namespace twin::plant

namespace twin::page {

/// State of the arm for the page. Units, frames: as RobotState.
struct ArmView {
  Time at{};  ///< of the run's clock
  JointVector q{};
  JointVector dq{};
  JointVector tau_J{};
  JointVector q_d{};
  JointVector dq_d{};
  JointVector ddq_d{};
  Vector6 O_F_ext_hat_K{};
  Transform O_T_EE = kIdentityTransform;
  RobotMode mode = RobotMode::kOther;
  bool follows_reference = true;    ///< false: torque control, q_d is meaningless
  RobotErrors errors;               ///< current
  RobotErrors reflex_reason;        ///< that ended the last motion
  std::optional<BaseState> base{};  ///< nullopt without a mobile base
  std::uint64_t served = 0;         ///< cycles so far with a command in time
  std::uint64_t held = 0;           ///< cycles so far without one
};

/// Observes a run's records: forwards them unchanged, and publishes the newest about sixty times
/// per second of run time, arm data to one thread and scenes to others.
///
///     cycles --> LiveFeed --> the run's own sink
///                   |--> [LatestValue], twice --> web server's thread
///                   `--> [LatestValue] --> camera's thread
///
/// Threads: Put() as RecordSink's; Show() and KeepPace() before the first Put(); arm(), scene(),
/// shown() and places() one consumer each. Real-time: Put() as the next sink's plus one copy; waits
/// only to keep pace and in a pause.
class LiveFeed final : public record::RecordSink {
 public:
  /// @param next  may be null; must outlive this.
  explicit LiveFeed(record::RecordSink* next) noexcept : next_(next) {}

  /// Also publishes scenes. @param truth  must outlive the run.
  /// @pre truth.qpos_size() <= record::SceneRecord::kMostPositions.
  void Show(const plant::TruthProbe& truth) noexcept { truth_ = &truth; }

  /// Slows a run on a virtual clock to wall-clock speed at most, without effect on its results.
  /// @param wall  must outlive the run.
  /// @param interrupted  ends a pause; null: never. Must outlive the run.
  void KeepPace(const MonotonicClock& wall, const volatile bool* interrupted = nullptr) noexcept {
    wall_ = &wall;
    interrupted_ = interrupted;
  }

  /// Lets a run that keeps pace stand at its next cycle, or go on, without effect on its results.
  /// Threads: any, as the next.
  void Pause(bool on) noexcept { paused_.store(on, std::memory_order_relaxed); }
  [[nodiscard]] bool is_paused() const noexcept { return paused_.load(std::memory_order_relaxed); }

  void Put(const record::CycleRecord& record) noexcept TWIN_REALTIME override;
  void Put(const record::TickRecord& record) noexcept TWIN_REALTIME override;

  [[nodiscard]] rt::LatestValue<ArmView>& arm() noexcept { return arm_; }
  [[nodiscard]] rt::LatestValue<record::SceneRecord>& scene() noexcept { return scene_; }
  /// As scene(), for viewers that draw it themselves.
  [[nodiscard]] rt::LatestValue<record::SceneRecord>& shown() noexcept { return shown_; }
  /// As scene(), for whoever asks where things are.
  [[nodiscard]] rt::LatestValue<record::SceneRecord>& places() noexcept { return places_; }

 private:
  void Wait(Time now) noexcept;

  record::RecordSink* const next_;
  const plant::TruthProbe* truth_ = nullptr;
  const MonotonicClock* wall_ = nullptr;
  const volatile bool* interrupted_ = nullptr;
  std::atomic<bool> paused_{false};  ///< relaxed: publishes no other data
  std::optional<Duration> behind_;   ///< lag of the run's time behind the wall clock
  Time next_view_{};
  std::uint64_t served_ = 0;
  std::uint64_t held_ = 0;
  rt::LatestValue<ArmView> arm_;
  rt::LatestValue<record::SceneRecord> scene_;
  rt::LatestValue<record::SceneRecord> shown_;
  rt::LatestValue<record::SceneRecord> places_;
};

}  // namespace twin::page
