#include "conformance/error_table.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include <fmt/format.h>

#include "support/panda_limits.h"
#include "twin/scenario/robot_data.h"

namespace twin::test {
namespace {

/// One of the two streams of a row.
class RowRun {
 public:
  RowRun(const ErrorRow& row, const HarnessCase& harness, double x)
      : robot_(Prepared(row, x)),
        rig_(harness.make(robot_), robot_, row.plant == robot::PlantKind::kIdeal),
        trial_(rig_, row.modes) {
    row.stream(trial_, x);
  }

  [[nodiscard]] Rig& rig() { return rig_; }

 private:
  static robot::RobotConfig Prepared(const ErrorRow& row, double x) {
    robot::RobotConfig robot = HarnessRobot(row.plant);
    robot.onboard.limits = row.arm.joints;
    robot.onboard.cartesian = row.arm.cartesian;
    if (row.prepare) row.prepare(robot, x);
    return robot;
  }

  robot::RobotConfig robot_;
  Rig rig_;
  Trial trial_;
};

RobotErrors Expected(const ErrorRow& row) {
  RobotErrors errors = row.beside;
  errors.set(static_cast<std::size_t>(row.error));
  return errors;
}

/// Whether the value is beyond the limit, and near it: the streams go there in small steps.
bool IsJustBeyond(const Violation& violation) {
  const double beyond = std::abs(violation.value - violation.limit);
  if (!(beyond <= std::abs(violation.limit))) return false;
  switch (violation.error) {
    case RobotError::kCommunicationConstraintsViolation: return violation.value >= violation.limit;
    case RobotError::kSelfCollisionAvoidanceViolation: return violation.value < violation.limit;
    case RobotError::kJointPositionLimitsViolation:
    case RobotError::kJointMotionGeneratorPositionLimitsViolation:
    case RobotError::kCartesianMotionGeneratorElbowLimitViolation:
    case RobotError::kCartesianMotionGeneratorJointPositionLimitsViolation: return beyond > 0;
    default: return std::abs(violation.value) > std::abs(violation.limit);
  }
}

void CheckViolation(const ErrorRow& row, const Violation& violation,
                    std::vector<std::string>& failures) {
  if (violation.axis != row.axis) {
    failures.push_back(fmt::format("axis {}, should be {}", violation.axis, row.axis));
  }
  if (row.limit != 0 && std::abs(std::abs(violation.limit) - row.limit) > 1e-9 * row.limit) {
    failures.push_back(fmt::format("limit {}, should be {}", violation.limit, row.limit));
  }
  if (violation.error == RobotError::kCartesianMotionGeneratorElbowSignInconsistent) return;
  if (!IsJustBeyond(violation)) {
    failures.push_back(
        fmt::format("value {} is not just beyond limit {}", violation.value, violation.limit));
  }
}

void CheckOutside(const ErrorRow& row, Rig& rig, std::vector<std::string>& failures) {
  const RobotState& state = rig.state();
  if (state.robot_mode != RobotMode::kReflex || state.reflex_reason != Expected(row)) {
    failures.push_back(fmt::format("mode {} for {}, should be Reflex for {}; {}",
                                   Name(state.robot_mode), FormatErrors(state.reflex_reason),
                                   FormatErrors(Expected(row)), rig.refusal()));
    return;
  }
  const backend::Description told = rig.Describe();
  if (told.last_end != backend::MotionEnd::kAborted) failures.emplace_back("not told as aborted");
  int found = 0;
  for (const Violation& violation : told.violations) {
    if (violation.error != row.error) continue;
    ++found;
    CheckViolation(row, violation, failures);
  }
  if (found != 1) failures.push_back(fmt::format("{} violations of the error", found));
  if (row.persists) return;
  if (!rig.RecoverToIdle()) {
    failures.push_back(fmt::format("does not recover: {}", rig.refusal()));
  } else if (rig.state().errors.any()) {
    failures.emplace_back("recovery leaves errors");
  }
}

void CheckInside(Rig& rig, std::vector<std::string>& failures) {
  const RobotState& state = rig.state();
  if (state.robot_mode == RobotMode::kMove && state.errors.none()) return;
  failures.push_back(fmt::format("the neighbour ends in mode {} for {}; {}", Name(state.robot_mode),
                                 FormatErrors(state.reflex_reason), rig.refusal()));
}

std::string TitleOf(const ErrorRow& row) {
  const bool is_cartesian = row.modes.generator >= MotionGeneratorMode::kCartesianPosition;
  return fmt::format("{}{}{}", Name(row.modes.generator),
                     is_cartesian && row.with_elbow ? " with elbow" : "",
                     row.modes.controller == ControllerMode::kExternalController ? ", torque" : "");
}

}  // namespace

std::vector<std::string> CheckRow(const ErrorRow& row, const HarnessCase& harness) {
  std::vector<std::string> failures;
  RowRun outside(row, harness, row.outside);
  CheckOutside(row, outside.rig(), failures);
  RowRun inside(row, harness, row.inside);
  CheckInside(inside.rig(), failures);
  for (Rig* rig : {&outside.rig(), &inside.rig()}) {
    if (rig->finding()) failures.push_back("breaks a rule: " + *rig->finding());
  }
  return failures;
}

std::string NameOf(const ErrorRow& row, std::size_t index) {
  std::string name = fmt::format("{:03}_{}_{}", index, Name(row.error), TitleOf(row));
  std::replace_if(
      name.begin(), name.end(), [](char c) { return c == ' ' || c == ','; }, '_');
  return name;
}

ArmLimits PandaArm() {
  return {PandaLimits(), PandaCartesianLimits()};
}

ArmLimits Fr3Arm() {
  const std::filesystem::path file = TWIN_SOURCE_DIR "/models/robots/fr3/limits.yaml";
  return {scenario::LoadJointLimits(file), scenario::LoadCartesianLimits(file)};
}

std::vector<ErrorRow> CommandErrorTable(const ArmLimits& arm) {
  std::vector<ErrorRow> table;
  for (const auto& part : {CommonErrorRows(arm), JointErrorRows(arm), CartesianErrorRows(arm),
                           CompletionErrorRows(arm)}) {
    table.insert(table.end(), part.begin(), part.end());
  }
  for (ErrorRow& row : table) row.arm = arm;
  return table;
}

std::vector<ErrorRow> ErrorTable() {
  std::vector<ErrorRow> table = CommandErrorTable(PandaArm());
  for (const ErrorRow& row : MeasuredErrorRows()) {
    table.push_back(row);
    table.back().arm = PandaArm();
  }
  std::stable_sort(table.begin(), table.end(),
                   [](const ErrorRow& a, const ErrorRow& b) { return a.error < b.error; });
  return table;
}

std::string Markdown(const std::vector<ErrorRow>& rows) {
  std::string text =
      "# What raises which error\n\n"
      "Every error a motion can be aborted for, the least that provokes it, and what is still "
      "allowed beside it. Each row is a test (tests/conformance).\n\n"
      "| # | error | motion | aborted for | allowed |\n|---|---|---|---|---|\n";
  for (const ErrorRow& row : rows) {
    text += fmt::format("| {} | {} | {} | {} | {} |\n", static_cast<int>(row.error),
                        Name(row.error), TitleOf(row), row.cause, row.neighbour);
  }
  return text;
}

}  // namespace twin::test
