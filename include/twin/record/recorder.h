#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <stop_token>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "twin/core/time.h"
#include "twin/record/log_records.h"
#include "twin/record/write_failure.h"
#include "twin/rt/cycle_record.h"
#include "twin/rt/scene_record.h"

namespace twin::record {

/// What a producer does when the ring to the writer is full.
enum class FullRing {
  kWait,  ///< lockstep: waits for the writer, so that nothing is lost
  kDrop,  ///< realtime: drops the record and counts it
};

/// What a finished recording holds.
struct RecordingSummary {
  std::uint64_t messages = 0;
  std::uint64_t bytes = 0;    ///< length of the file
  std::uint64_t dropped = 0;  ///< records and events that found the ring full; always 0 with kWait
};

/// Records a run into an MCAP file with protobuf messages.
///
/// kWait: one producer thread, one ring. The order of the file is that of the calls, and the same
/// calls give the same bytes.
///
///     Put(cycle) --+
///     Put(scene) --+                   +----------------+
///     Put(tick)  --+-- ring of 1024 -->| writer thread  |--> <path>.partial, <path> when finished
///     Event(...) --+                   | encode, chunk  |
///                                      +----------------+
///
/// kDrop: three producer threads, each with a ring of its own: robot, communication, onlooker. The
/// file holds each kind in the order of its calls; between kinds, log time tells.
///
///     Put(scene) --+
///     Put(cycle) --+-- ring of 1024 -->+----------------+
///     Put(tick)  ----- ring of 1024 -->| writer thread  |--> the same
///     Event(...) ----- ring of 64 ---->+----------------+
///
/// Topics: /robot/config (when it changes), /robot/cycle, /ext/tick, /event, /scene (as often as
/// scenes are put: at each frame of the video), /plan, and /tf, 50 times a second: the arm's frames
/// from the measured q, a foxglove.FrameTransforms that moves the robot's URDF in Foxglove's 3D
/// panel. Log time is the run's time line; of a plan, when it was made. Plans are written last.
/// Metadata "run" and "limits" and attachment "scenario.yaml" tell what was run. A killed process
/// loses the open chunk (512 kB before compression, about 0.2 s of cycles) and what the ring still
/// held.
///
/// Threads: with kWait one producer thread; with kDrop one for cycles and scenes, one for ticks,
/// one for events. Add() and Finish() after the producers are done. Real-time: Put() and Event()
/// copy the record into the ring, nothing else; with kWait they may sleep. When the writer fails,
/// the failure is kept for Finish() and records are thrown away: no producer is held up.
class Recorder final : public rt::RecordSink {
 public:
  /// A chunk ends before it would hold more, uncompressed.
  static constexpr std::size_t kChunkBytes = std::size_t{512} * 1024;

  /// Creates `<path>.partial`. @throws EnvironmentError when that is not possible.
  Recorder(const std::filesystem::path& path, const RunInfo& run, FullRing full_ring,
           std::size_t chunk_bytes = kChunkBytes);
  /// Without Finish(): writes what was put and leaves `<path>.partial`.
  ~Recorder() override;
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  void Put(const rt::CycleRecord& record) noexcept TWIN_REALTIME override;
  void Put(const rt::TickRecord& record) noexcept TWIN_REALTIME override;

  /// As a cycle.
  void Put(const rt::SceneRecord& record) noexcept TWIN_REALTIME;

  /// Something happened. @param kind  one word, cut at 31 bytes. @param text  cut at 2000 bytes.
  void Event(Time at, std::string_view kind, std::string_view text) noexcept TWIN_REALTIME;

  /// What was planned; kept for Finish(). Not for real-time code.
  void Add(PlanRecord plan);

  /// Why nothing is written any more, as soon as that is so; empty: all is well. Threads: any.
  [[nodiscard]] std::string Failure() const { return failure_.Text(); }

  /// Writes everything out and gives the file its name. Call once.
  /// @throws EnvironmentError when anything could not be written, now or before.
  RecordingSummary Finish();

 private:
  class Ring;
  class Writer;

  template <class Fill>
  void Push(const std::unique_ptr<Ring>& own, Fill&& fill) noexcept;
  void Run(const std::stop_token& stop);
  /// Writes what the rings hold, a batch at most. @returns how many records that were.
  std::size_t Drain();
  void StopThread();

  const FullRing full_ring_;
  std::unique_ptr<Writer> writer_;  ///< the writer thread's, then Finish()'s
  std::unique_ptr<Ring> cycles_;
  std::unique_ptr<Ring> ticks_;   ///< null: ticks go with the cycles
  std::unique_ptr<Ring> events_;  ///< null: events go with the cycles
  /// Counts drained batches; a producer that found the ring full sleeps on it. Release by the
  /// writer after it freed slots, acquire by the producer before it tries again.
  std::atomic<std::uint32_t> drained_{0};
  std::atomic<std::uint64_t> dropped_{0};  ///< a count only: relaxed
  std::vector<PlanRecord> plans_;          ///< whose calls Add() and Finish() are
  WriteFailure failure_;                   ///< the writer thread's
  std::jthread thread_;
};

}  // namespace twin::record
