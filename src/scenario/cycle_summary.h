#pragma once

#include <cstdint>

#include "scenario/word_hash.h"
#include "twin/rt/cycle_record.h"
#include "twin/scenario/assembly.h"

namespace twin::scenario {

/// Counts and fingerprints the cycles that pass through on their way to another sink.
///
/// Threads and real-time: as rt::RecordSink.
class CycleSummary final : public rt::RecordSink {
 public:
  /// @param next  may be null; must outlive this.
  explicit CycleSummary(rt::RecordSink* next) : next_(next) {}

  void Put(const rt::CycleRecord& record) noexcept TWIN_REALTIME override;
  void Put(const rt::TickRecord& record) noexcept TWIN_REALTIME override;

  [[nodiscard]] const CycleCounts& counts() const noexcept { return counts_; }
  [[nodiscard]] std::uint64_t states_hash() const noexcept { return hash_.value(); }

 private:
  void AddState(const RobotState& state) noexcept;

  rt::RecordSink* next_;
  CycleCounts counts_;
  WordHash hash_;
};

}  // namespace twin::scenario
