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
#include "twin/record/cycle_record.h"
#include "twin/record/log_records.h"
#include "twin/record/log_split.h"
#include "twin/record/scene_record.h"
#include "twin/record/write_failure.h"

namespace twin::record {

/// Behaviour of a producer when the ring to the writer is full.
enum class FullRing {
  kWait,  ///< lockstep: waits for the writer, so that no record is lost
  kDrop,  ///< realtime: drops the record and counts it
};

/// Contents of a finished recording.
struct RecordingSummary {
  std::uint64_t messages = 0;
  std::uint64_t bytes = 0;    ///< length of the files
  std::uint64_t dropped = 0;  ///< records and events dropped at a full ring; always 0 with kWait
};

/// Records a run into an MCAP file, or several (LogSplit), with protobuf messages.
///
/// kWait: one producer thread, one ring. The file has the order of the calls, and the same calls
/// give the same bytes.
///
///     Put(cycle) --+
///     Put(scene) --+                   +----------------+
///     Put(tick)  --+-- ring of 1024 -->| writer thread  |--> <path>.partial, <path> when finished
///     Event(...) --+                   | encode, chunk  |
///                                      +----------------+
///
/// kDrop: three producer threads, each with its own ring: robot, communication, observer. The file
/// has each kind in the order of its calls; log time orders different kinds.
///
///     Put(scene) --+
///     Put(cycle) --+-- ring of 1024 -->+----------------+
///     Put(tick)  ----- ring of 1024 -->| writer thread  |--> the same
///     Event(...) ----- ring of 64 ---->+----------------+
///
/// Topics: /robot/config (on change), /robot/cycle, /ext/tick, /event, /scene (as often as scenes
/// are put: one per video frame), /plan, and /tf, 50 times per second: the arm's frames from the
/// measured q as foxglove.FrameTransforms, which move the robot's URDF in Foxglove's 3D panel. Log
/// time is the run's clock; for a plan, the time of planning. Plans are written last. Metadata
/// "run" and "limits" and attachment "scenario.yaml" describe the run. A killed process loses the
/// open chunk (512 kB before compression, about 0.2 s of cycles) and the content of the rings.
///
/// Threads: with kWait one producer thread; with kDrop one for cycles and scenes, one for ticks,
/// one for events. Add() and Finish() after the producers have ended. Real-time: Put() and Event()
/// only copy the record into the ring; with kWait they may sleep. After a writer failure, records
/// are discarded and Finish() throws the failure: no producer is blocked.
class Recorder final : public RecordSink {
 public:
  /// Uncompressed size limit of a chunk.
  static constexpr std::size_t kChunkBytes = std::size_t{512} * 1024;

  /// Creates `<path>.partial`, or that of the first file. @throws EnvironmentError if it cannot.
  Recorder(const std::filesystem::path& path, const RunInfo& run, FullRing full_ring,
           const LogSplit& split = {}, std::size_t chunk_bytes = kChunkBytes);
  /// Without Finish(): writes the records that were put and leaves `<path>.partial`.
  ~Recorder() override;
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  void Put(const CycleRecord& record) noexcept TWIN_REALTIME override;
  void Put(const TickRecord& record) noexcept TWIN_REALTIME override;

  /// As Put() of a cycle.
  void Put(const SceneRecord& record) noexcept TWIN_REALTIME;

  /// Records an event. @param kind  one word, cut at 31 bytes. @param text  cut at 2000 bytes.
  void Event(Time at, std::string_view kind, std::string_view text) noexcept TWIN_REALTIME;

  /// Keeps a plan for Finish(). Not for real-time code.
  void Add(PlanRecord plan);

  /// Reason why writing has stopped; empty while it works. Threads: any.
  [[nodiscard]] std::string Failure() const { return failure_.Text(); }

  /// Writes the remaining records and renames the file to its final name. Call once.
  /// @throws EnvironmentError if any write has failed.
  RecordingSummary Finish();

 private:
  class Ring;
  class Writer;

  template <class Fill>
  void Push(const std::unique_ptr<Ring>& own, Fill&& fill) noexcept;
  void Run(const std::stop_token& stop);
  /// Writes at most a batch from the rings. @returns the number of records written.
  std::size_t Drain();
  void StopThread();

  const FullRing full_ring_;
  std::unique_ptr<Writer> writer_;  ///< owned by the writer thread, then by Finish()
  std::unique_ptr<Ring> cycles_;
  std::unique_ptr<Ring> ticks_;   ///< null: ticks use the ring of the cycles
  std::unique_ptr<Ring> events_;  ///< null: events use the ring of the cycles
  /// Counts drained batches; a producer that found its ring full sleeps on it. Release by the
  /// writer after it freed slots, acquire by the producer before it retries.
  std::atomic<std::uint32_t> drained_{0};
  std::atomic<std::uint64_t> dropped_{0};  ///< a counter: relaxed
  std::vector<PlanRecord> plans_;          ///< owned by the thread that calls Add() and Finish()
  WriteFailure failure_;                   ///< owned by the writer thread
  std::jthread thread_;
};

}  // namespace twin::record
