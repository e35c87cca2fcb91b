#include "record/column_sources.h"

#include <string_view>
#include <utility>

#include <google/protobuf/descriptor.h>

#include "record/log_fields.h"
#include "twin/core/error.h"
#include "twin/core/modes.h"
#include "twin/core/robot_errors.h"
#include "twin/record/scene_record.h"

namespace twin::record {
namespace {

using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;

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

template <class Enum>
std::vector<std::string> NamesOf(int count) {
  using record::Name;
  using twin::Name;
  std::vector<std::string> names;
  names.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) names.emplace_back(Name(static_cast<Enum>(i)));
  return names;
}

std::vector<std::string> NamesOf(const google::protobuf::EnumDescriptor& type) {
  const int count = type.value_count();
  const std::string& name = type.name();
  if (name == "CommandFate") return NamesOf<CommandFate>(count);
  if (name == "TickAction") return NamesOf<TickAction>(count);
  if (name == "BaseMode") return NamesOf<BaseMode>(count);
  if (name == "RobotMode") return NamesOf<RobotMode>(count);
  if (name == "MotionGeneratorMode") return NamesOf<MotionGeneratorMode>(count);
  TWIN_CHECK(name == "ControllerMode");
  return NamesOf<ControllerMode>(count);
}

Coding CodingOf(const FieldDescriptor& field) {
  switch (field.cpp_type()) {
    case FieldDescriptor::CPPTYPE_DOUBLE:
      return field.is_repeated() ? Coding::kDoubles : Coding::kDouble;
    case FieldDescriptor::CPPTYPE_INT64: return Coding::kTime;
    case FieldDescriptor::CPPTYPE_UINT64: return Coding::kUint64;
    case FieldDescriptor::CPPTYPE_UINT32: return Coding::kUint32;
    case FieldDescriptor::CPPTYPE_BOOL: return Coding::kBool;
    case FieldDescriptor::CPPTYPE_ENUM:
      return field.is_repeated() ? Coding::kErrors : Coding::kEnum;
    case FieldDescriptor::CPPTYPE_MESSAGE: return Coding::kViolation;
    default: return Coding::kString;
  }
}

ColumnType TypeOf(Coding coding) {
  switch (coding) {
    case Coding::kDouble:
    case Coding::kDoubles: return ColumnType::kFloat64;
    case Coding::kTime: return ColumnType::kInt64;
    case Coding::kUint64: return ColumnType::kUint64;
    case Coding::kUint32: return ColumnType::kUint32;
    case Coding::kBool: return ColumnType::kBool;
    default: return ColumnType::kText;
  }
}

struct LogTable {
  TableInfo info;
  TableSource source;
};

/// Builds a table from the fields of its messages.
class Columns {
 public:
  /// @param row  the field of `message` whose occurrences are the rows; empty: the message itself.
  Columns(TableInfo info, const Descriptor& message, const std::string& row = {})
      : table_{std::move(info), {.type = message.full_name()}}, message_(message) {
    if (row.empty()) return;
    const FieldDescriptor& field = *message.FindFieldByName(row);
    table_.source.row_field = field.number();
    row_ = field.message_type();
  }

  /// A field, or `message.field`. @param name  of the column; empty: the field's.
  Columns& Add(const std::string& field, std::string unit, std::string meaning,
               const std::string& name = {}) {
    const bool is_time = table_.info.columns.empty();
    const Descriptor* of = row_ != nullptr && !is_time ? row_ : &message_;
    ColumnSource source;
    const std::size_t dot = field.find('.');
    if (dot != std::string::npos) {
      const FieldDescriptor& outer = *of->FindFieldByName(field.substr(0, dot));
      source.path.push_back(outer.number());
      of = outer.message_type();
    }
    const FieldDescriptor* const found = of->FindFieldByName(field.substr(dot + 1));
    TWIN_CHECK(found != nullptr);
    source.path.push_back(found->number());
    source.coding = CodingOf(*found);
    if (source.coding == Coding::kEnum) source.names = NamesOf(*found->enum_type());
    ColumnInfo& column = table_.info.columns.emplace_back();
    column.name = name.empty() ? found->name() : name;
    column.type = TypeOf(source.coding);
    column.is_vector = source.coding == Coding::kDoubles;
    column.unit = std::move(unit);
    column.meaning = std::move(meaning);
    table_.source.columns.push_back(std::move(source));
    return *this;
  }

  Columns& AddVector(std::size_t width, const std::string& field, std::string unit,
                     std::string meaning) {
    Add(field, std::move(unit), std::move(meaning));
    table_.info.columns.back().width = width;
    return *this;
  }

  /// The vectors that the encoder writes. @param message  that holds them; empty: the row's.
  template <class Fields>
  Columns& AddVectors(const Fields& fields, const std::string& message = {}) {
    for (const auto& field : fields) {
      AddVector(WidthOf(field), message + std::string(field.name), std::string(field.unit),
                std::string(field.meaning));
    }
    return *this;
  }

  Columns& MayBeAbsent() {
    table_.info.columns.back().may_be_absent = true;
    return *this;
  }
  Columns& AtMost(std::uint32_t most) {
    table_.source.columns.back().most = most;
    return *this;
  }
  Columns& Elements(std::vector<std::string> names) {
    table_.info.columns.back().elements = std::move(names);
    return *this;
  }

  LogTable Done() { return std::move(table_); }

 private:
  template <class Record, class Message>
  static std::size_t WidthOf(const VectorField<Record, Message>& field) {
    return field.values(Record()).size();
  }

  LogTable table_;
  const Descriptor& message_;
  const Descriptor* row_ = nullptr;
};

LogTable Cycles() {
  return Columns({.name = "cycles",
                  .topic = std::string(kCycleTopic),
                  .meaning = "A cycle of the robot's controller, as the robot saw it.",
                  .is_basic = true,
                  .columns = {}},
                 *pb::Cycle::descriptor())
      .Add("at_ns", "ns", "Start of the cycle on the run's clock")
      .Add("message_id", "ms", "Of the state sent in this cycle: since the robot's start")
      .Add("fate", "", "What the controller did with the command of the cycle")
      .Add("lost_in_row", "", "Consecutive held cycles so far")
      .Add("dropped", "", "Commands that were too late, duplicated or had a wrong id")
      .Add("robot_mode", "", "Mode of the robot")
      .Add("motion_generator_mode", "", "Source of the reference; idle: no motion")
      .Add("controller_mode", "", "Controller that converts the reference to torque")
      .Add("errors", "", "Present errors, joined by a vertical bar")
      .Add("reflex_reason", "", "Errors that ended the previous motion, joined by a vertical bar")
      .Add("control_command_success_rate", "",
           "Share of the last 100 commands that arrived; 0 without a motion")
      .Add("violation", "", "The limit that this cycle violated, in a sentence")
      .AddVectors(kCycleFields)
      .Done();
}

LogTable Configs() {
  return Columns({.name = "config",
                  .topic = std::string(kConfigTopic),
                  .meaning = "The rarely changing rest of the robot's state: a row per change.",
                  .is_basic = true,
                  .columns = {}},
                 *pb::Config::descriptor())
      .Add("at_ns", "ns", "Cycle from which it holds, on the run's clock")
      .Add("m_ee", "kg", "Mass of the end effector")
      .Add("m_load", "kg", "Mass of the load")
      .AddVectors(kConfigFields)
      .Done();
}

LogTable Ticks() {
  return Columns({.name = "ticks",
                  .topic = std::string(kTickTopic),
                  .meaning = "A tick of the workstation, and the command that it wrote.",
                  .is_basic = true,
                  .columns = {}},
                 *pb::Tick::descriptor())
      .Add("read_ns", "ns", "End of the state's read on the run's clock")
      .Add("written_ns", "ns", "End of the command's write; d_EXT = written_ns - read_ns")
      .Add("message_id", "ms", "Of the state that paced the tick")
      .Add("action", "", "What the tick did")
      .Add("skipped_states", "", "States that never arrived since the last tick")
      .Add("deposit_time_ns", "ns", "Source time of the present deposit")
      .Add("command.message_id", "ms", "Of the state that the command answers",
           "command_message_id")
      .Add("command.valid_elbow", "", "The command sets the elbow")
      .Add("command.motion_generation_finished", "", "The command asks for the motion's end")
      .AddVectors(kTickFields)
      .AddVectors(kCommandFields, "command.")
      .Add("kept_back", "", "Joints whose command the viability filter changed, bit i for joint i")
      .AtMost((1U << kJoints) - 1)
      .Add("margin", "", "Smallest joint margin to the border of the viable set")
      .MayBeAbsent()
      .Add("stalled", "", "The source counts as stalled")
      .Done();
}

LogTable Events() {
  return Columns({.name = "events",
                  .topic = std::string(kEventTopic),
                  .meaning = "Mode changes, errors, recoveries, steps, as text.",
                  .is_basic = true,
                  .columns = {}},
                 *pb::Event::descriptor())
      .Add("at_ns", "ns", "Time on the run's clock")
      .Add("kind", "", "One word, such as mode, error, recovery")
      .Add("text", "", "What happened")
      .Done();
}

LogTable Base() {
  return Columns({.name = "base",
                  .topic = std::string(kCycleTopic),
                  .meaning = "A mobile base below the arm, as its drives measure it, per cycle.",
                  .columns = {}},
                 *pb::Cycle::descriptor(), "base")
      .Add("at_ns", "ns", "Start of the cycle on the run's clock")
      .Add("message_id", "", "Number of the base's state")
      .Add("mode", "", "Mode of the base")
      .Add("x", "m", "Odometry from the pose at power-on")
      .Add("y", "m", "As x")
      .Add("yaw", "rad", "As x; not wrapped")
      .Add("v", "m/s", "Forward speed, from the wheels")
      .Add("w", "rad/s", "Rate of yaw, from the wheels")
      .Add("v_d", "m/s", "Commanded speed, after its limits")
      .Add("w_d", "rad/s", "Commanded rate of yaw, after its limits")
      .AddVector(std::tuple_size_v<decltype(BaseState::dq_wheels)>, "dq_wheels", "rad/s",
                 "Speeds of the wheels: front left, front right, rear left, rear right")
      .Elements({"dq_front_left", "dq_front_right", "dq_rear_left", "dq_rear_right"})
      .Done();
}

LogTable Accelerometers() {
  constexpr std::size_t kWidth = std::tuple_size_v<Accelerations>;
  return Columns({.name = "accelerometers",
                  .topic = std::string(kCycleTopic),
                  .meaning = "Proper acceleration of an FR3's links 0 to 5, in the sensors' axes, "
                             "per cycle: link n, axis r is element 3 n + r.",
                  .columns = {}},
                 *pb::Cycle::descriptor(), "accelerometers")
      .Add("at_ns", "ns", "Start of the cycle on the run's clock")
      .AddVector(kWidth, "top", "m/s^2", "Of the upper sensor of each link")
      .AddVector(kWidth, "bottom", "m/s^2", "Of the lower sensor of each link")
      .Done();
}

LogTable Forces(std::string name, const std::string& field, std::string meaning) {
  constexpr std::size_t kAxes = 3;
  return Columns({.name = std::move(name),
                  .topic = std::string(kSceneTopic),
                  .meaning = std::move(meaning),
                  .columns = {}},
                 *pb::Scene::descriptor(), field)
      .Add("at_ns", "ns", "Time of the scene on the run's clock")
      .AddVector(kAxes, "p_W", "m", "Point of application, world")
      .AddVector(kAxes, "force_W", "N", "Force, world")
      .Done();
}

LogTable Scenes() {
  return Columns({.name = "scenes",
                  .topic = std::string(kSceneTopic),
                  .meaning = "True positions of all bodies at an instant of the video; simulated "
                             "robots only.",
                  .columns = {}},
                 *pb::Scene::descriptor())
      .Add("at_ns", "ns", "Time on the run's clock")
      .AddVector(0, "qpos", "", "Generalised positions in the model's order; m, rad, quaternions")
      .Done();
}

LogTable Plans() {
  return Columns({.name = "plans",
                  .topic = std::string(kPlanTopic),
                  .meaning = "Planned and executed motions; the paths serve pictures and are left "
                             "out.",
                  .columns = {}},
                 *pb::Plan::descriptor())
      .Add("from_ns", "ns", "Time of planning on the run's clock")
      .Add("until_ns", "ns", "End of the execution")
      .Add("id", "", "Name of the motion")
      .Add("caption", "", "One sentence")
      .AddVector(kJoints, "q", "rad", "The arm's goal")
      .MayBeAbsent()
      .Add("object", "", "Body that the arm carries")
      .AddVector(std::tuple_size_v<Transform>, "O_T_object", "",
                 "Its goal in O, 4 x 4, column-major; m")
      .Done();
}

const std::vector<LogTable>& AllTables() {
  static const std::vector<LogTable> tables = [] {
    std::vector<LogTable> all;
    all.push_back(Cycles());
    all.push_back(Configs());
    all.push_back(Ticks());
    all.push_back(Events());
    all.push_back(Base());
    all.push_back(Accelerometers());
    all.push_back(
        Forces("contacts", "contacts",
               "Contact forces at the instants of scenes, on the body of the larger id."));
    all.push_back(Forces("pushes", "pushes", "Forces of perturbations at the instants of scenes."));
    all.push_back(Scenes());
    all.push_back(Plans());
    return all;
  }();
  return tables;
}

}  // namespace

const std::vector<TableInfo>& LogTables() {
  static const std::vector<TableInfo> infos = [] {
    std::vector<TableInfo> all;
    for (const LogTable& table : AllTables()) all.push_back(table.info);
    return all;
  }();
  return infos;
}

const std::vector<TableSource>& TableSources() {
  static const std::vector<TableSource> sources = [] {
    std::vector<TableSource> all;
    for (const LogTable& table : AllTables()) all.push_back(table.source);
    return all;
  }();
  return sources;
}

const TableSource& SourceOf(const TableInfo& table) {
  const std::ptrdiff_t place = &table - LogTables().data();
  TWIN_CHECK(place >= 0 && place < std::ssize(LogTables()));
  return TableSources()[static_cast<std::size_t>(place)];
}

}  // namespace twin::record
