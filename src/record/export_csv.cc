#include "twin/record/export_csv.h"

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>

#include <fmt/format.h>

#include "record/csv_file.h"
#include "record/log_fields.h"
#include "twin/core/error.h"
#include "twin/core/modes.h"
#include "twin/core/robot_errors.h"
#include "twin/record/log_reader.h"

namespace twin::record {
namespace {

std::string_view Name(CommandFate fate) {
  switch (fate) {
    case CommandFate::kNone: return "none";
    case CommandFate::kServed: return "served";
    case CommandFate::kHeld: return "held";
  }
  return "unknown";
}

std::string_view Name(TickAction action) {
  switch (action) {
    case TickAction::kPublished: return "published";
    case TickAction::kWritten: return "written";
    case TickAction::kFinished: return "finished";
    case TickAction::kSkipped: return "skipped";
    case TickAction::kInvalid: return "invalid";
    case TickAction::kLimited: return "limited";
  }
  return "unknown";
}

std::string_view Name(BaseMode mode) {
  switch (mode) {
    case BaseMode::kStanding: return "standing";
    case BaseMode::kDriving: return "driving";
    case BaseMode::kEmergencyStop: return "emergency_stop";
  }
  return "unknown";
}

std::string Names(const RobotErrors& errors) {
  std::string names;
  for (std::size_t i = 0; i < errors.size(); ++i) {
    if (!errors[i]) continue;
    if (!names.empty()) names += '|';
    names += twin::Name(static_cast<RobotError>(i));
  }
  return names;
}

std::int64_t Nanoseconds(Time time) {
  return time.time_since_epoch().count();
}

template <class Record, class Table>
void AddVectorNames(CsvFile& csv, const Table& table) {
  const Record record{};
  for (const auto& field : table) csv.AddNames(field.name, field.values(record).size());
}

template <class Record, class Table>
void AddVectors(CsvFile& csv, const Table& table, const Record& record) {
  for (const auto& field : table) csv.AddValues(field.values(record));
}

/// All files of one export.
class CsvFiles {
 public:
  explicit CsvFiles(const std::filesystem::path& folder)
      : cycles_(folder / "cycles.csv"),
        configs_(folder / "config.csv"),
        ticks_(folder / "ticks.csv"),
        events_(folder / "events.csv"),
        base_path_(folder / "base.csv") {
    AddHeadings();
  }

  void operator()(const CycleRecord& record) {
    if (!config_ || !SameConfig(*config_, record.state)) AddConfig(record);
    const RobotState& state = record.state;
    cycles_.Add(Nanoseconds(record.at));
    cycles_.Add(state.message_id);
    cycles_.Add(Name(record.fate));
    cycles_.Add(record.lost_in_row);
    cycles_.Add(record.dropped);
    cycles_.Add(twin::Name(state.robot_mode));
    cycles_.Add(twin::Name(state.motion_generator_mode));
    cycles_.Add(twin::Name(state.controller_mode));
    cycles_.Add(std::string_view(Names(state.errors)));
    cycles_.Add(std::string_view(Names(state.reflex_reason)));
    cycles_.Add(state.control_command_success_rate);
    cycles_.Add(std::string_view(record.violated ? Describe(record.violation) : std::string()));
    AddVectors(cycles_, kCycleFields, record);
    cycles_.EndRow();
    if (record.base) AddBase(record.at, *record.base);
    ++written_.cycles;
  }

  void operator()(const TickRecord& record) {
    ticks_.Add(Nanoseconds(record.read));
    ticks_.Add(Nanoseconds(record.written));
    ticks_.Add(record.message_id);
    ticks_.Add(Name(record.action));
    ticks_.Add(record.skipped_states);
    ticks_.Add(Nanoseconds(record.deposit_time));
    ticks_.Add(record.command.message_id);
    ticks_.Add(record.command.valid_elbow ? 1 : 0);
    ticks_.Add(record.command.motion_generation_finished ? 1 : 0);
    AddVectors(ticks_, kTickFields, record);
    AddVectors(ticks_, kCommandFields, record.command);
    ticks_.Add(record.kept_back);
    ticks_.Add(std::string_view(record.margin ? fmt::format("{}", *record.margin) : std::string()));
    ticks_.Add(record.stalled ? 1 : 0);
    ticks_.EndRow();
    ++written_.ticks;
  }

  void operator()(const EventRecord& event) {
    events_.Add(Nanoseconds(event.at));
    events_.Add(std::string_view(event.kind));
    events_.Add(std::string_view(event.text));
    events_.EndRow();
    ++written_.events;
  }

  void operator()(const SceneRecord& /*scene*/) {}
  void operator()(const PlanRecord& /*plan*/) {}

  CsvExport Commit() {
    for (CsvFile* file : {&cycles_, &configs_, &ticks_, &events_}) file->Commit();
    if (base_) base_->Commit();
    return written_;
  }

 private:
  static void AddTexts(CsvFile& csv, std::initializer_list<std::string_view> names) {
    for (const std::string_view name : names) csv.Add(name);
  }

  void AddHeadings() {
    AddTexts(cycles_, {"at_ns", "message_id", "fate", "lost_in_row", "dropped", "robot_mode",
                       "motion_generator_mode", "controller_mode", "errors", "reflex_reason",
                       "control_command_success_rate", "violation"});
    AddVectorNames<CycleRecord>(cycles_, kCycleFields);
    AddTexts(configs_, {"at_ns", "m_ee", "m_load"});
    AddVectorNames<RobotState>(configs_, kConfigFields);
    AddTexts(ticks_,
             {"read_ns", "written_ns", "message_id", "action", "skipped_states", "deposit_time_ns",
              "command_message_id", "valid_elbow", "motion_generation_finished"});
    AddVectorNames<TickRecord>(ticks_, kTickFields);
    AddVectorNames<RobotCommand>(ticks_, kCommandFields);
    AddTexts(ticks_, {"kept_back", "margin", "stalled"});
    AddTexts(events_, {"at_ns", "kind", "text"});
    for (CsvFile* file : {&cycles_, &configs_, &ticks_, &events_}) file->EndRow();
  }

  void AddConfig(const CycleRecord& record) {
    config_ = record.state;
    configs_.Add(Nanoseconds(record.at));
    configs_.Add(record.state.m_ee);
    configs_.Add(record.state.m_load);
    AddVectors(configs_, kConfigFields, record.state);
    configs_.EndRow();
  }

  /// Creates the file on the first record of a mobile base.
  void AddBase(Time at, const BaseState& base) {
    if (!base_) {
      base_.emplace(base_path_);
      AddTexts(*base_, {"at_ns", "message_id", "mode", "x", "y", "yaw", "v", "w", "v_d", "w_d",
                        "dq_front_left", "dq_front_right", "dq_rear_left", "dq_rear_right"});
      base_->EndRow();
    }
    base_->Add(Nanoseconds(at));
    base_->Add(base.message_id);
    base_->Add(Name(base.mode));
    base_->AddValues(std::array{base.odometry.x, base.odometry.y, base.odometry.yaw, base.twist.v,
                                base.twist.w, base.twist_d.v, base.twist_d.w});
    base_->AddValues(base.dq_wheels);
    base_->EndRow();
  }

  CsvFile cycles_;
  CsvFile configs_;
  CsvFile ticks_;
  CsvFile events_;
  const std::filesystem::path base_path_;
  std::optional<CsvFile> base_;
  std::optional<RobotState> config_;
  CsvExport written_;
};

}  // namespace

CsvExport ExportCsv(const std::filesystem::path& log, const std::filesystem::path& folder) {
  LogReader reader(log);
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) {
    throw EnvironmentError(fmt::format("cannot create folder {}: {}; choose another one",
                                       folder.string(), error.message()));
  }
  CsvFiles files(folder);
  LogEntry entry;
  while (reader.Next(entry)) std::visit(files, entry);
  CsvExport written = files.Commit();
  written.truncated = reader.truncated();
  return written;
}

}  // namespace twin::record
