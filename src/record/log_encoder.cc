#include "record/log_encoder.h"

#include <algorithm>
#include <array>
#include <bit>
#include <string>

#include <google/protobuf/descriptor.h>
#include <google/protobuf/descriptor.pb.h>

#include "record/log_fields.h"
#include "record/log_text.h"
#include "twin/core/error.h"

namespace twin::record {
namespace {

/// True if all bits are zero; -0.0 counts as a value.
bool AllZero(std::span<const double> values) {
  std::uint64_t bits = 0;
  for (const double value : values) bits |= std::bit_cast<std::uint64_t>(value);
  return bits == 0;
}

template <class Table, class Record, class Message>
void EncodeVectors(const Table& table, const Record& record, Message& message) {
  for (const auto& field : table) {
    const auto values = field.values(record);
    if (!AllZero(values)) field.repeated(message)->Add(values.begin(), values.end());
  }
}

template <class Add>
void EncodeErrors(const RobotErrors& errors, Add&& add) {
  if (errors.none()) return;
  for (std::size_t i = 0; i < errors.size(); ++i) {
    if (errors[i]) add(static_cast<pb::RobotError>(i));
  }
}

void Encode(const Violation& violation, pb::Violation& message) {
  message.set_error(static_cast<pb::RobotError>(violation.error));
  message.set_axis(violation.axis);
  message.set_value(violation.value);
  message.set_limit(violation.limit);
  message.set_message_id(violation.message_id);
}

/// A robot without accelerometers has zeros; one with them never, since they feel gravity.
void Encode(const Accelerations& top, const Accelerations& bottom, pb::Cycle& cycle) {
  if (top == Accelerations{} && bottom == Accelerations{}) return;
  pb::Accelerometers& message = *cycle.mutable_accelerometers();
  message.mutable_top()->Add(top.begin(), top.end());
  message.mutable_bottom()->Add(bottom.begin(), bottom.end());
}

void Encode(const BaseState& base, pb::Base& message) {
  message.set_message_id(base.message_id);
  message.set_mode(static_cast<pb::BaseMode>(base.mode));
  message.set_x(base.odometry.x);
  message.set_y(base.odometry.y);
  message.set_yaw(base.odometry.yaw);
  message.set_v(base.twist.v);
  message.set_w(base.twist.w);
  message.set_v_d(base.twist_d.v);
  message.set_w_d(base.twist_d.w);
  message.mutable_dq_wheels()->Add(base.dq_wheels.begin(), base.dq_wheels.end());
}

void Encode(const PointForce& force, pb::PointForce& message) {
  message.mutable_p_w()->Add(force.p_W.begin(), force.p_W.end());
  message.mutable_force_w()->Add(force.force_W.begin(), force.force_W.end());
}

void Encode(const RobotCommand& command, pb::Command& message) {
  message.set_message_id(command.message_id);
  message.set_valid_elbow(command.valid_elbow);
  message.set_motion_generation_finished(command.motion_generation_finished);
  EncodeVectors(kCommandFields, command, message);
}

/// Adds a file after its imports, each once, so that the set can be read front to back.
void AddWithImports(const google::protobuf::FileDescriptor& file,
                    google::protobuf::FileDescriptorSet& files) {
  for (int i = 0; i < file.dependency_count(); ++i) AddWithImports(*file.dependency(i), files);
  for (const auto& known : files.file()) {
    if (known.name() == file.name()) return;
  }
  file.CopyTo(files.add_file());
}

/// Registers schema and channel of one message type.
template <class Message>
std::uint16_t AddChannel(McapWriter& writer, std::string_view topic) {
  google::protobuf::FileDescriptorSet files;
  AddWithImports(*Message::descriptor()->file(), files);
  const std::uint16_t schema =
      writer.AddSchema(Message::descriptor()->full_name(), "protobuf", files.SerializeAsString());
  return writer.AddChannel(schema, topic, "protobuf");
}

}  // namespace

LogEncoder::LogEncoder(McapWriter& writer, const RunInfo& run) : writer_(writer) {
  writer_.AddMetadata(kRunMetadata, {{kScenarioKey, ToUtf8(run.scenario)},
                                     {kSeedKey, std::to_string(run.seed)},
                                     {kVersionKey, ToUtf8(run.version)},
                                     {kDriveKey, ToUtf8(run.drive)}});
  if (run.limits) writer_.AddMetadata(kLimitsMetadata, LimitsToMetadata(*run.limits));
  writer_.AddAttachment(kScenarioAttachment, "application/yaml", run.scenario_yaml);
  config_channel_ = AddChannel<pb::Config>(writer_, kConfigTopic);
  cycle_channel_ = AddChannel<pb::Cycle>(writer_, kCycleTopic);
  tick_channel_ = AddChannel<pb::Tick>(writer_, kTickTopic);
  event_channel_ = AddChannel<pb::Event>(writer_, kEventTopic);
  frames_channel_ = AddChannel<foxglove::FrameTransforms>(writer_, kFramesTopic);
  scene_channel_ = AddChannel<pb::Scene>(writer_, kSceneTopic);
  plan_channel_ = AddChannel<pb::Plan>(writer_, kPlanTopic);
}

void LogEncoder::Add(const CycleRecord& record) {
  if (!has_config_ || !SameConfig(config_, record.state)) AddConfig(record.at, record.state);
  const RobotState& state = record.state;
  cycle_.Clear();
  cycle_.set_at_ns(record.at.time_since_epoch().count());
  cycle_.set_message_id(state.message_id);
  cycle_.set_fate(static_cast<pb::CommandFate>(record.fate));
  cycle_.set_lost_in_row(record.lost_in_row);
  cycle_.set_dropped(record.dropped);
  cycle_.set_robot_mode(static_cast<pb::RobotMode>(state.robot_mode));
  cycle_.set_motion_generator_mode(
      static_cast<pb::MotionGeneratorMode>(state.motion_generator_mode));
  cycle_.set_controller_mode(static_cast<pb::ControllerMode>(state.controller_mode));
  EncodeErrors(state.errors, [this](pb::RobotError error) { cycle_.add_errors(error); });
  EncodeErrors(state.reflex_reason,
               [this](pb::RobotError error) { cycle_.add_reflex_reason(error); });
  cycle_.set_control_command_success_rate(state.control_command_success_rate);
  if (record.violated) Encode(record.violation, *cycle_.mutable_violation());
  if (record.base) Encode(*record.base, *cycle_.mutable_base());
  Encode(state.accelerometer_top, state.accelerometer_bottom, cycle_);
  EncodeVectors(kCycleFields, record, cycle_);
  Write(cycle_channel_, record.at, cycle_);
  const foxglove::FrameTransforms* frames = frames_.Next(record.at, state.q);
  if (frames != nullptr) Write(frames_channel_, record.at, *frames);
}

void LogEncoder::Add(const TickRecord& record) {
  tick_.Clear();
  tick_.set_read_ns(record.read.time_since_epoch().count());
  tick_.set_written_ns(record.written.time_since_epoch().count());
  tick_.set_message_id(record.message_id);
  tick_.set_action(static_cast<pb::TickAction>(record.action));
  tick_.set_skipped_states(record.skipped_states);
  tick_.set_deposit_time_ns(record.deposit_time.time_since_epoch().count());
  if (record.margin) tick_.set_margin(*record.margin);
  tick_.set_kept_back(record.kept_back);
  tick_.set_stalled(record.stalled);
  Encode(record.command, *tick_.mutable_command());
  EncodeVectors(kTickFields, record, tick_);
  Write(tick_channel_, record.read, tick_);
}

void LogEncoder::Add(Time at, std::string_view kind, std::string_view text) {
  event_.Clear();
  event_.set_at_ns(at.time_since_epoch().count());
  event_.set_kind(ToUtf8(kind));
  event_.set_text(ToUtf8(text));
  Write(event_channel_, at, event_);
}

void LogEncoder::Add(const SceneRecord& record) {
  scene_.Clear();
  scene_.set_at_ns(record.at.time_since_epoch().count());
  const std::span<const double> qpos = record.Positions();
  scene_.mutable_qpos()->Add(qpos.begin(), qpos.end());
  for (const PointForce& contact : record.Contacts()) Encode(contact, *scene_.add_contacts());
  for (const PointForce& push : record.Pushes()) Encode(push, *scene_.add_pushes());
  Write(scene_channel_, record.at, scene_);
}

void LogEncoder::Add(const PlanRecord& record) {
  TWIN_CHECK(record.path.size() <= PlanRecord::kMostPoints);
  plan_.Clear();
  plan_.set_id(ToUtf8(record.id));
  plan_.set_caption(ToUtf8(record.caption));
  plan_.set_from_ns(record.from.time_since_epoch().count());
  plan_.set_until_ns(record.until.time_since_epoch().count());
  if (record.q) plan_.mutable_q()->Add(record.q->begin(), record.q->end());
  for (const Vector3& point : record.path) plan_.mutable_way()->Add(point.begin(), point.end());
  plan_.set_object(ToUtf8(record.object));
  if (!record.object.empty()) {
    plan_.mutable_o_t_object()->Add(record.O_T_object.begin(), record.O_T_object.end());
  }
  Write(plan_channel_, record.from, plan_);
}

void LogEncoder::AddConfig(Time at, const RobotState& state) {
  config_ = state;
  has_config_ = true;
  config_message_.Clear();
  config_message_.set_at_ns(at.time_since_epoch().count());
  config_message_.set_m_ee(state.m_ee);
  config_message_.set_m_load(state.m_load);
  EncodeVectors(kConfigFields, state, config_message_);
  Write(config_channel_, at, config_message_);
}

template <class Message>
void LogEncoder::Write(std::uint16_t channel, Time at, const Message& message) {
  const auto log_time = std::max<std::int64_t>(at.time_since_epoch().count(), 0);
  const auto place =
      writer_.AddMessage(channel, static_cast<std::uint64_t>(log_time), message.ByteSizeLong());
  auto* const begin = reinterpret_cast<std::uint8_t*>(place.data());
  TWIN_CHECK(message.SerializeWithCachedSizesToArray(begin) == begin + place.size());
}

}  // namespace twin::record
