#pragma once

#include <functional>
#include <string>
#include <vector>

#include "twin/core/time.h"

namespace twin::application {

/// How one attempt at a step ended.
struct StepEnd {
  bool succeeded = true;
  std::string text{};  ///< why not, or a remark for the report
};

/// A step of a task: a state of its machine.
struct TaskStep {
  std::string name;                ///< unique within the task
  std::function<StepEnd()> act{};  ///< one attempt
  /// Step at which the task continues after a failure: this or an earlier one. Empty: the failure
  /// ends the task.
  std::string after_failure{};
  int attempts = 1;  ///< in all, >= 1; the failure of the last one ends the task
};

/// One attempt at a step.
struct StepReport {
  std::string name;
  int attempt = 1;  ///< counted from 1
  Time begun{};
  Time ended{};
  bool succeeded = false;
  std::string text{};  ///< as StepEnd's
};

struct TaskReport {
  std::vector<StepReport> steps;  ///< all attempts, in order of execution
  std::string failure;            ///< failed step and cause; empty: the task succeeded
};

/// Executes steps, each after the success of the previous one. After a failed attempt, the task
/// continues at the step's `after_failure` while the failed step has attempts left. Attempts are
/// counted over the whole task, so the task ends.
///
/// A step that throws RobotFault has failed with its text and is not repeated, because the robot
/// refuses commands or does not answer. Other exceptions propagate.
/// @param now  the robot's time. @param on_attempt  receives each finished attempt; may be empty.
/// @param interrupted  called before each attempt; true ends the task; may be empty.
/// @throws InputError if two steps have the same name, attempts are below 1, or `after_failure` is
/// neither the step itself nor an earlier one.
[[nodiscard]] TaskReport Carry(const std::vector<TaskStep>& steps, const std::function<Time()>& now,
                               const std::function<void(const StepReport&)>& on_attempt = {},
                               const std::function<bool()>& interrupted = {});

}  // namespace twin::application
