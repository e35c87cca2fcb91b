#pragma once

#include <cstdint>

#include "twin/core/hash.h"
#include "twin/record/cycle_record.h"
#include "twin/rt/latest_value.h"
#include "twin/run/run.h"

namespace twin::run {

/// What has been counted so far.
struct CycleTally {
  CycleCounts motion;         ///< since the last motion began, what came behind it too
  std::uint64_t motions = 0;  ///< that began: robot_mode became Move
};

/// Counts and fingerprints the cycles that pass through on their way to another sink.
///
/// Threads and real-time: as record::RecordSink; Tally() from one thread at any time; the rest
/// while nothing is put.
class CycleSummary final : public record::RecordSink {
 public:
  /// @param next  may be null; must outlive this.
  explicit CycleSummary(record::RecordSink* next) : next_(next) {}

  void Put(const record::CycleRecord& record) noexcept TWIN_REALTIME override;
  void Put(const record::TickRecord& record) noexcept TWIN_REALTIME override;

  /// As of the last cycle put. Valid until the next call.
  [[nodiscard]] const CycleTally& Tally() noexcept {
    static_cast<void>(shown_.Refresh());
    return shown_.value();
  }
  [[nodiscard]] const CycleCounts& counts() const noexcept { return counted_.counts; }
  [[nodiscard]] const record::FilterCounts& viability() const noexcept { return viability_; }
  [[nodiscard]] std::uint64_t states_hash() const noexcept { return counted_.hash.value(); }

  /// All that is counted, by the cycles' thread and by the ticks'.
  struct Counted {
    CycleCounts counts;
    WordHash hash;
    bool moving = false;
    CycleTally tally;
  };
  struct Copy {
    Counted counted;
    record::FilterCounts viability;
  };
  [[nodiscard]] Copy Save() const { return {counted_, viability_}; }
  /// Goes back to what was counted at Save(). @param ahead  of the times of further ticks, which
  /// the next sink shall get in order.
  void Restore(const Copy& copy, Duration ahead) noexcept {
    counted_ = copy.counted;
    viability_ = copy.viability;
    ahead_ = ahead;
    shown_.Publish(counted_.tally);
  }

 private:
  void AddState(const RobotState& state) noexcept;
  void AddBase(const BaseState& base) noexcept;
  void CountMotion(const record::CycleRecord& record) noexcept;

  record::RecordSink* next_;
  Counted counted_;
  record::FilterCounts viability_;  ///< written by the ticks' thread, all else by the cycles'
  Duration ahead_{};
  rt::LatestValue<CycleTally> shown_;
};

}  // namespace twin::run
