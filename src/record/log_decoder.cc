#include "record/log_decoder.h"

#include <algorithm>

#include <fmt/format.h>

#include "record/log_text.h"
#include "twin/core/error.h"

namespace twin::record {
namespace {

template <class Message>
void Parse(std::span<const std::byte> data, Message& message) {
  if (data.size() > kMaxMessageBytes) {
    throw InputError(fmt::format("a message of {} bytes; at most {} are accepted", data.size(),
                                 kMaxMessageBytes));
  }
  if (!message.ParseFromArray(data.data(), static_cast<int>(data.size()))) {
    throw InputError(fmt::format("not a message of type {}", message.GetTypeName()));
  }
}

using Doubles = google::protobuf::RepeatedField<double>;

void DecodeVector(std::string_view name, const Doubles& from, std::span<double> to) {
  if (from.empty()) {
    std::ranges::fill(to, 0.0);
    return;
  }
  if (static_cast<std::size_t>(from.size()) != to.size()) {
    throw InputError(
        fmt::format("{} has {} values; it must have {} or none", name, from.size(), to.size()));
  }
  std::ranges::copy(from, to.begin());
}

template <class Table, class Record, class Message>
void DecodeVectors(const Table& table, Message& message, Record& record) {
  for (const auto& field : table) {
    DecodeVector(field.name, *field.repeated(message), field.mutable_values(record));
  }
}

/// @returns `count`. @throws InputError if it exceeds `most`.
std::uint32_t DecodeCount(std::string_view name, int count, std::size_t most) {
  if (static_cast<std::size_t>(count) > most) {
    throw InputError(fmt::format("{} are {}; at most {} are accepted", name, count, most));
  }
  return static_cast<std::uint32_t>(count);
}

/// @returns `bits`, one per joint.
std::uint8_t DecodeJoints(std::string_view name, std::uint32_t bits) {
  constexpr std::uint32_t kAll = (1U << kJoints) - 1;
  if (bits > kAll) {
    throw InputError(fmt::format("{} is {}; at most {}, a bit for each of {} joints, is accepted",
                                 name, bits, kAll, kJoints));
  }
  return static_cast<std::uint8_t>(bits);
}

void DecodeForces(const google::protobuf::RepeatedPtrField<pb::PointForce>& from,
                  std::span<PointForce> to) {
  for (int i = 0; i < from.size(); ++i) {
    PointForce& force = to[static_cast<std::size_t>(i)];
    DecodeVector("p_W", from[i].p_w(), force.p_W);
    DecodeVector("force_W", from[i].force_w(), force.force_W);
  }
}

std::vector<Vector3> DecodePoints(const Doubles& from) {
  constexpr int kNumbers = 3;
  if (from.size() % kNumbers != 0) {
    throw InputError(fmt::format("way has {} values; it must have 3 for each point", from.size()));
  }
  std::vector<Vector3> points(
      DecodeCount("points of way", from.size() / kNumbers, PlanRecord::kMostPoints));
  for (std::size_t i = 0; i < points.size(); ++i) {
    std::copy_n(from.begin() + static_cast<std::ptrdiff_t>(kNumbers * i), kNumbers,
                points[i].begin());
  }
  return points;
}

/// @returns our enumerator with the message's number.
template <class Enum>
Enum DecodeEnum(const char* field, int value, bool valid) {
  if (!valid) throw InputError(fmt::format("{} has the unknown value {}", field, value));
  return static_cast<Enum>(value);
}

RobotError DecodeError(int value) {
  return DecodeEnum<RobotError>("an error", value, pb::RobotError_IsValid(value));
}

RobotErrors DecodeErrors(const google::protobuf::RepeatedField<int>& numbers) {
  RobotErrors errors;
  for (const int number : numbers) errors.set(static_cast<std::size_t>(DecodeError(number)));
  return errors;
}

BaseState DecodeBase(const pb::Base& message) {
  BaseState base;
  base.message_id = message.message_id();
  base.mode = DecodeEnum<BaseMode>("mode of the base", message.mode(),
                                   pb::BaseMode_IsValid(message.mode()));
  base.odometry = {message.x(), message.y(), message.yaw()};
  base.twist = {message.v(), message.w()};
  base.twist_d = {message.v_d(), message.w_d()};
  DecodeVector("dq_wheels", message.dq_wheels(), base.dq_wheels);
  return base;
}

}  // namespace

Violation DecodeViolation(const pb::Violation& message) {
  if (message.axis() < -1 || message.axis() >= static_cast<int>(kJoints)) {
    throw InputError(fmt::format("axis of a violation is {}; it must be in [-1, {}]",
                                 message.axis(), kJoints - 1));
  }
  return {.error = DecodeError(message.error()),
          .axis = static_cast<std::int8_t>(message.axis()),
          .value = message.value(),
          .limit = message.limit(),
          .message_id = message.message_id()};
}

Time DecodeTime(std::int64_t ns) {
  constexpr std::int64_t kMost = 1'000'000'000'000'000'000;
  if (ns < -kMost || ns > kMost) {
    throw InputError(
        fmt::format("a time of {} ns; at most {}, which is 31 years, is accepted", ns, kMost));
  }
  return Time(Duration(ns));
}

void LogDecoder::TakeConfig(std::span<const std::byte> data) {
  Parse(data, config_message_);
  config_.m_ee = config_message_.m_ee();
  config_.m_load = config_message_.m_load();
  DecodeVectors(kConfigFields, config_message_, config_);
}

void LogDecoder::Decode(std::span<const std::byte> data, CycleRecord& record) {
  Parse(data, cycle_);
  record = {};
  RobotState& state = record.state;
  state = config_;
  record.at = DecodeTime(cycle_.at_ns());
  state.message_id = cycle_.message_id();
  record.fate =
      DecodeEnum<CommandFate>("fate", cycle_.fate(), pb::CommandFate_IsValid(cycle_.fate()));
  record.lost_in_row = cycle_.lost_in_row();
  record.dropped = cycle_.dropped();
  state.robot_mode = DecodeEnum<RobotMode>("robot_mode", cycle_.robot_mode(),
                                           pb::RobotMode_IsValid(cycle_.robot_mode()));
  state.motion_generator_mode = DecodeEnum<MotionGeneratorMode>(
      "motion_generator_mode", cycle_.motion_generator_mode(),
      pb::MotionGeneratorMode_IsValid(cycle_.motion_generator_mode()));
  state.controller_mode =
      DecodeEnum<ControllerMode>("controller_mode", cycle_.controller_mode(),
                                 pb::ControllerMode_IsValid(cycle_.controller_mode()));
  state.errors = DecodeErrors(cycle_.errors());
  state.reflex_reason = DecodeErrors(cycle_.reflex_reason());
  state.control_command_success_rate = cycle_.control_command_success_rate();
  record.violated = cycle_.has_violation();
  if (record.violated) record.violation = DecodeViolation(cycle_.violation());
  if (cycle_.has_base()) record.base = DecodeBase(cycle_.base());
  DecodeVector("accelerometers' top", cycle_.accelerometers().top(), state.accelerometer_top);
  DecodeVector("accelerometers' bottom", cycle_.accelerometers().bottom(),
               state.accelerometer_bottom);
  DecodeVectors(kCycleFields, cycle_, record);
}

void LogDecoder::Decode(std::span<const std::byte> data, TickRecord& record) {
  Parse(data, tick_);
  record = {};
  record.read = DecodeTime(tick_.read_ns());
  record.written = DecodeTime(tick_.written_ns());
  record.message_id = tick_.message_id();
  record.action =
      DecodeEnum<TickAction>("action", tick_.action(), pb::TickAction_IsValid(tick_.action()));
  record.skipped_states = tick_.skipped_states();
  record.deposit_time = DecodeTime(tick_.deposit_time_ns());
  if (tick_.has_margin()) record.margin = tick_.margin();
  record.kept_back = DecodeJoints("kept_back", tick_.kept_back());
  record.stalled = tick_.stalled();
  pb::Command& command = *tick_.mutable_command();
  record.command.message_id = command.message_id();
  record.command.valid_elbow = command.valid_elbow();
  record.command.motion_generation_finished = command.motion_generation_finished();
  DecodeVectors(kCommandFields, command, record.command);
  DecodeVectors(kTickFields, tick_, record);
}

void LogDecoder::Decode(std::span<const std::byte> data, EventRecord& record) {
  Parse(data, event_);
  record = {.at = DecodeTime(event_.at_ns()),
            .kind = ToPrintable(event_.kind()),
            .text = ToPrintable(event_.text())};
}

void LogDecoder::Decode(std::span<const std::byte> data, SceneRecord& record) {
  Parse(data, scene_);
  record = {};
  record.at = DecodeTime(scene_.at_ns());
  record.positions = DecodeCount("values of qpos", scene_.qpos_size(), record.qpos.size());
  std::ranges::copy(scene_.qpos(), record.qpos.begin());
  record.contacts = DecodeCount("contacts", scene_.contacts_size(), record.contact.size());
  DecodeForces(scene_.contacts(), record.contact);
  record.pushes = DecodeCount("pushes", scene_.pushes_size(), record.push.size());
  DecodeForces(scene_.pushes(), record.push);
}

void LogDecoder::Decode(std::span<const std::byte> data, PlanRecord& record) {
  Parse(data, plan_);
  record = {.id = ToPrintable(plan_.id()),
            .caption = ToPrintable(plan_.caption()),
            .from = DecodeTime(plan_.from_ns()),
            .until = DecodeTime(plan_.until_ns()),
            .path = DecodePoints(plan_.way()),
            .object = ToPrintable(plan_.object())};
  if (!plan_.q().empty()) DecodeVector("q", plan_.q(), record.q.emplace());
  if (!plan_.o_t_object().empty()) {
    DecodeVector("O_T_object", plan_.o_t_object(), record.O_T_object);
  }
}

}  // namespace twin::record
