#pragma once

#include <cstdint>
#include <string_view>

#include "record/arm_frames.h"
#include "record/log_fields.h"
#include "twin/core/robot_state.h"
#include "twin/record/cycle_record.h"
#include "twin/record/log_records.h"
#include "twin/record/mcap_writer.h"
#include "twin/record/scene_record.h"

namespace twin::record {

/// Encodes records as messages of log.proto and foxglove.proto and adds them to an MCAP file.
/// Messages are reused, so that no record allocates.
///
/// Threads: one thread. Real-time: no. Errors: those of McapWriter.
class LogEncoder {
 public:
  /// Adds schemas, channels, metadata and the scenario. @param writer  must outlive the encoder.
  LogEncoder(McapWriter& writer, const RunInfo& run);

  /// Adds the cycle, preceded by a changed configuration and followed by the arm's frames if due.
  void Add(const CycleRecord& record);
  void Add(const TickRecord& record);
  /// Bytes that are not UTF-8 become '?'.
  void Add(Time at, std::string_view kind, std::string_view text);
  void Add(const SceneRecord& record);
  /// Texts as in events. @pre at most PlanRecord::kMostPoints points.
  void Add(const PlanRecord& record);

 private:
  void AddConfig(Time at, const RobotState& state);
  template <class Message>
  void Write(std::uint16_t channel, Time at, const Message& message);

  McapWriter& writer_;
  std::uint16_t cycle_channel_ = 0;
  std::uint16_t config_channel_ = 0;
  std::uint16_t tick_channel_ = 0;
  std::uint16_t event_channel_ = 0;
  std::uint16_t frames_channel_ = 0;
  std::uint16_t scene_channel_ = 0;
  std::uint16_t plan_channel_ = 0;
  bool has_config_ = false;
  RobotState config_;  ///< the last written configuration
  pb::Cycle cycle_;
  pb::Config config_message_;
  pb::Tick tick_;
  pb::Event event_;
  pb::Scene scene_;
  pb::Plan plan_;
  ArmFrames frames_;
};

}  // namespace twin::record
