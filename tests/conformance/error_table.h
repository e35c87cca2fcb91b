#pragma once

#include <functional>
#include <string>
#include <vector>

#include "conformance/trial.h"
#include "twin/core/limits.h"
#include "twin/core/modes.h"
#include "twin/core/robot_errors.h"
#include "twin/robot/robot_config.h"

namespace twin::test {

/// Whose limits a table is about.
struct ArmLimits {
  JointLimits joints;
  CartesianLimits cartesian;
};
[[nodiscard]] ArmLimits PandaArm();
/// An FR3: from models/robots/fr3.
[[nodiscard]] ArmLimits Fr3Arm();

/// One way to provoke an error through the backend, and the stream beside it that is still good.
struct ErrorRow {
  RobotError error{};
  MotionModes modes;
  bool with_elbow = false;
  robot::PlantKind plant = robot::PlantKind::kIdeal;
  std::string cause;      ///< what the stream does
  std::string neighbour;  ///< what it does in place of it, without any error
  /// Goes into `prepare` and `stream`: how far the limit is used, 1 being exactly all of it, unless
  /// the row says otherwise.
  double outside = 1.001;
  double inside = 0.999;
  ArmLimits arm;  ///< the robot's; set by the tables
  std::function<void(robot::RobotConfig& robot, double x)> prepare;  ///< may be empty
  /// Starts the motion and commands it. After the good stream the robot must still show Move.
  std::function<void(Trial& trial, double x)> stream;
  int axis = -1;          ///< that the violation must name
  double limit = 0;       ///< that it must name, magnitude; 0: whatever it is
  bool persists = false;  ///< what raises it is still there after the motion: no recovery from it
  RobotErrors beside;     ///< companions of the same group that must be reported too
};

/// Every error that a motion of the Franka Control Interface can raise here, for every motion
/// generator it applies to, on a Panda.
[[nodiscard]] std::vector<ErrorRow> ErrorTable();
/// Those of them that commands raise, with an arm's limits.
[[nodiscard]] std::vector<ErrorRow> CommandErrorTable(const ArmLimits& arm);

/// Parts of it, by what the errors look at.
[[nodiscard]] std::vector<ErrorRow> JointErrorRows(const ArmLimits& arm);
[[nodiscard]] std::vector<ErrorRow> CartesianErrorRows(const ArmLimits& arm);
[[nodiscard]] std::vector<ErrorRow> CompletionErrorRows(const ArmLimits& arm);
[[nodiscard]] std::vector<ErrorRow> CommonErrorRows(const ArmLimits& arm);
[[nodiscard]] std::vector<ErrorRow> MeasuredErrorRows();

/// What came of a row: every claim that does not hold, as a text; empty: all hold.
[[nodiscard]] std::vector<std::string> CheckRow(const ErrorRow& row, const HarnessCase& harness);

/// "joint_position_x_y": of letters, digits and underscores, unlike any other row's.
[[nodiscard]] std::string NameOf(const ErrorRow& row, std::size_t index);

/// The table as a page of documentation.
[[nodiscard]] std::string Markdown(const std::vector<ErrorRow>& rows);

}  // namespace twin::test
