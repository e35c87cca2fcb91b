#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <variant>

#include "record/log_fields.h"
#include "twin/core/robot_state.h"
#include "twin/record/cycle_record.h"
#include "twin/record/log_records.h"
#include "twin/record/scene_record.h"

namespace twin::record {

/// Largest accepted message, far above our largest (about 2 kB).
inline constexpr std::size_t kMaxMessageBytes = std::size_t{64} * 1024;

/// @returns the time. @throws InputError for one that no run has: sums of two times do not
/// overflow.
[[nodiscard]] Time DecodeTime(std::int64_t ns);

/// @throws InputError naming the value that is out of range.
[[nodiscard]] Violation DecodeViolation(const pb::Violation& message);

/// Decodes messages of log.proto into records. The bytes are untrusted: lengths, enumerators and
/// ranges are checked; a bad value is an InputError naming the field.
///
/// Threads: one thread. Real-time: no.
class LogDecoder {
 public:
  /// Stores the configuration for the states of the following cycles.
  void TakeConfig(std::span<const std::byte> data);
  void Decode(std::span<const std::byte> data, CycleRecord& record);
  void Decode(std::span<const std::byte> data, TickRecord& record);
  void Decode(std::span<const std::byte> data, EventRecord& record);
  void Decode(std::span<const std::byte> data, SceneRecord& record);
  void Decode(std::span<const std::byte> data, PlanRecord& record);

 private:
  RobotState config_;  ///< default except for the configuration
  pb::Cycle cycle_;
  pb::Config config_message_;
  pb::Tick tick_;
  pb::Event event_;
  pb::Scene scene_;
  pb::Plan plan_;
};

}  // namespace twin::record
