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
