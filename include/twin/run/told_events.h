#pragma once

#include <array>
#include <cstddef>
#include <string_view>

#include "twin/core/realtime.h"
#include "twin/core/time.h"
#include "twin/record/cycle_record.h"
#include "twin/rt/spsc_ring.h"
#include "twin/run/run_records.h"

namespace twin::run {

/// Passes a robot's records on, and adds the lines of its server (server::TellPeople) to the log as
/// events, at the time of the next cycle, before that cycle.
///
///     server's thread:  Tell(line) --> ring of 64 --> Put(cycle) of the robot's thread
///
/// Kinds: `motion` for a motion of the arm ("started: ...", "finished", "aborted by reflex: ..."),
/// `client` for lines that begin with a client's address (the whole line), else the word before the
/// line's first colon: `arm`, `hand` or `control`.
///
/// Threads: Tell() from one at a time; Put() as RunRecords. Real-time: Put() and Tell() allocate
/// nothing. A line that finds the ring full is dropped.
class ToldEvents final : public record::RecordSink {
 public:
  /// @param records  must outlive this.
  explicit ToldEvents(RunRecords& records) : records_(records) {}

  /// @param line  cut at kMostLetters bytes.
  void Tell(std::string_view line) noexcept TWIN_REALTIME;

  void Put(const record::CycleRecord& record) noexcept TWIN_REALTIME override;
  void Put(const record::TickRecord& record) noexcept TWIN_REALTIME override {
    records_.Put(record);
  }

  /// Adds the lines told after the last cycle. @pre neither thread calls any more.
  void Finish() noexcept { PassOn(last_); }

 private:
  static constexpr std::size_t kMostLetters = 1000;
  static constexpr std::size_t kLines = 64;

  struct Line {
    std::size_t size = 0;
    std::array<char, kMostLetters> text{};
  };

  void PassOn(Time at) noexcept TWIN_REALTIME;

  RunRecords& records_;
  rt::SpscRing<Line> lines_{kLines};
  Time last_{};  ///< of the last cycle
};

}  // namespace twin::run
