#include "twin/fci/transcript.h"

#include <array>
#include <cstddef>
#include <string_view>
#include <type_traits>
#include <variant>

#include <fmt/format.h>

#include "fci/datagram_fields.h"
#include "fci/message_fields.h"

namespace twin::fci {
namespace {

class Lines {
 public:
  template <typename Value>
  void Add(std::string_view name, const Value& value) {
    text_ += fmt::format("    {} =", name);
    Append(value);
    text_ += '\n';
  }
  [[nodiscard]] std::string Take() { return std::move(text_); }

 private:
  void Append(bool value) { text_ += value ? " 1" : " 0"; }
  void Append(std::string_view value) { text_ += fmt::format(" {}", value); }
  void Append(const RobotErrors& errors) {
    if (errors.none()) text_ += " none";
    for (std::size_t i = 0; i < kRobotErrorCount; ++i) {
      if (errors[i]) Append(Name(static_cast<RobotError>(i)));
    }
  }
  void Append(const MotionModes& modes) {
    Append(Name(modes.controller));
    Append(Name(modes.generator));
  }
  void Append(const Deviation& deviation) {
    Append(deviation.translation);
    Append(deviation.rotation);
    Append(deviation.elbow);
  }
  template <typename Value, std::size_t kSize>
  void Append(const std::array<Value, kSize>& values) {
    for (const Value& value : values) Append(value);
  }
  template <typename Value>
  requires std::is_enum_v<Value>
  void Append(Value value) {
    if constexpr (requires { Name(value); }) {
      Append(std::string_view(Name(value)));
    } else {
      Append(static_cast<int>(value));
    }
  }
  template <typename Value>
  requires std::is_arithmetic_v<Value>
  void Append(Value value) { text_ += fmt::format(" {}", value); }

  std::string text_;
};

template <typename Struct, typename Fields>
std::string DatagramText(const Struct& message, const Fields& fields,
                         Protocol protocol = Protocol::k5) {
  Lines lines;
  const auto add = [&](const auto& field) {
    if (field.OffsetIn(protocol) != kAbsent) lines.Add(field.name, message.*(field.member));
  };
  std::apply([&](const auto&... field) { (add(field), ...); }, fields);
  return lines.Take();
}

template <Protocol kProtocol = Protocol::k5, typename T>
void AddFields(Lines& lines, const T& message) {
  std::apply([&](const auto&... field) { (lines.Add(field.name, message.*(field.member)), ...); },
             wire::kFieldsIn<T, kProtocol>);
}

template <Protocol kProtocol = Protocol::k5, typename T>
std::string MessageText(const T& message) {
  Lines lines;
  if constexpr (std::is_same_v<T, Setting> || std::is_same_v<T, HandCommand>) {
    std::visit([&](const auto& inner) { AddFields(lines, inner); }, message);
  } else {
    AddFields<kProtocol>(lines, message);
  }
  return lines.Take();
}

constexpr std::array<std::string_view, 10> kMoveStatus{"success",
                                                       "motion_started",
                                                       "preempted",
                                                       "command_not_possible_rejected",
                                                       "start_at_singular_pose_rejected",
                                                       "invalid_argument_rejected",
                                                       "reflex_aborted",
                                                       "emergency_aborted",
                                                       "input_error_aborted",
                                                       "aborted"};
constexpr std::array<std::string_view, 5> kStopStatus{
    "success", "command_not_possible_rejected", "emergency_aborted", "reflex_aborted", "aborted"};
constexpr std::array<std::string_view, 3> kSetterStatus{"success", "command_not_possible_rejected",
                                                        "invalid_argument_rejected"};
constexpr std::array<std::string_view, 6> kRecoveryStatus{"success",
                                                          "command_not_possible_rejected",
                                                          "manual_error_recovery_required_rejected",
                                                          "reflex_aborted",
                                                          "emergency_aborted",
                                                          "aborted"};
constexpr std::array<std::string_view, 2> kConnectStatus{"success", "incompatible_library_version"};
constexpr std::array<std::string_view, 2> kModelLibraryStatus{"success", "error"};

std::string_view StatusName(ArmCommand asked, std::uint8_t status) {
  const auto of = [status](const auto& names) -> std::string_view {
    return status < names.size() ? names[status] : "no status of this request";
  };
  switch (asked) {
    case ArmCommand::kConnect: return of(kConnectStatus);
    case ArmCommand::kMove: return of(kMoveStatus);
    case ArmCommand::kStopMove: return of(kStopStatus);
    case ArmCommand::kAutomaticErrorRecovery: return of(kRecoveryStatus);
    case ArmCommand::kLoadModelLibrary:
    case ArmCommand::kGetRobotModel: return of(kModelLibraryStatus);
    default: return of(kSetterStatus);
  }
}

std::string AnswerText(const HandAnswer& answer, bool is_connect) {
  Lines lines;
  lines.Add("status", Name(answer.result));
  if (is_connect) lines.Add("version", answer.version);
  return lines.Take();
}

}  // namespace

std::string FieldsOf(const RobotState& state, Protocol protocol) {
  return DatagramText(state, kStateFields, protocol);
}

std::string FieldsOf(const RobotCommand& command) {
  return DatagramText(command, kCommandFields);
}

std::string FieldsOf(const HandState& state) {
  return DatagramText(state, kHandStateFields);
}

std::string FieldsOf(const VacuumState& state) {
  return DatagramText(state, kVacuumStateFields);
}

std::string FieldsOf(const ArmRequest& request, Protocol protocol) {
  return std::visit(
      [protocol](const auto& message) {
        return protocol == Protocol::k5 ? MessageText(message)
                                        : MessageText<Protocol::k10>(message);
      },
      request);
}

std::string FieldsOf(const HandRequest& request) {
  return std::visit([](const auto& message) { return MessageText(message); }, request);
}

std::string FieldsOf(ArmCommand asked, const ArmAnswer& answer) {
  Lines lines;
  lines.Add("status", fmt::format("{} ({})", answer.status, StatusName(asked, answer.status)));
  if (asked == ArmCommand::kConnect) lines.Add("version", answer.version);
  if (asked == ArmCommand::kGetCartesianLimit) AddFields(lines, answer.limit);
  if (asked == ArmCommand::kLoadModelLibrary || asked == ArmCommand::kGetRobotModel) {
    lines.Add(asked == ArmCommand::kGetRobotModel ? "urdf" : "library",
              fmt::format("{} bytes", answer.library.size()));
  }
  return lines.Take();
}

std::string FieldsOf(HandCommandId asked, const HandAnswer& answer) {
  return AnswerText(answer, asked == HandCommandId::kConnect);
}

std::string FieldsOf(VacuumCommandId asked, const HandAnswer& answer) {
  return AnswerText(answer, asked == VacuumCommandId::kConnect);
}

}  // namespace twin::fci
