#pragma once

#include <cstdint>
#include <filesystem>

#include "twin/core/hash.h"
#include "twin/record/cycle_record.h"

namespace twin::campaign {

/// A fingerprint of what a log holds of cycles and ticks, in order. Passes everything on.
///
/// Threads: the run's.
class RecordHash final : public record::RecordSink {
 public:
  /// @param next  may be null; must outlive this.
  explicit RecordHash(record::RecordSink* next = nullptr) : next_(next) {}

  void Put(const record::CycleRecord& record) noexcept TWIN_REALTIME override;
  void Put(const record::TickRecord& record) noexcept TWIN_REALTIME override;

  [[nodiscard]] std::uint64_t value() const { return hash_.value(); }

 private:
  record::RecordSink* const next_;
  WordHash hash_;
};

/// The same of a log that was written. @throws as record::LogReader.
[[nodiscard]] std::uint64_t RecordHashOf(const std::filesystem::path& log);

}  // namespace twin::campaign
