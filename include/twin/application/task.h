#pragma once

#include <functional>
#include <string>
#include <vector>

#include "twin/core/time.h"

namespace twin::application {

/// How one attempt at a step ended.
struct StepEnd {
  bool succeeded = true;
  std::string text{};  ///< why not, or what is worth telling
};

/// A step of a task: a state of its machine.
struct TaskStep {
  std::string name;                ///< another one for every step
  std::function<StepEnd()> act{};  ///< one attempt
  /// Where a failure leads: this step or one before it. Empty: the task has failed.
  std::string after_failure{};
  int attempts = 1;  ///< in all, >= 1; the last one's failure is the task's
};

/// What became of a step, attempt by attempt.
struct StepReport {
  std::string name;
  int attempt = 1;  ///< which one it was, from 1
  Time begun{};
  Time ended{};
  bool succeeded = false;
  std::string text{};  ///< as StepEnd's
};

/// What became of a task.
struct TaskReport {
  std::vector<StepReport> steps;  ///< in the order in which they were done
  std::string failure;            ///< which step failed and why; empty: the task succeeded
};

/// Carries out steps, each after the one before it has succeeded. A failed attempt goes on at the
/// step's `after_failure`, as long as the failed step has attempts left; attempts are counted over
/// the whole task, so that it ends.
///
/// A step that throws RobotFault has failed with that text, and is not tried again: the robot is
/// gone or has refused. Other exceptions pass.
/// @param now  the robot's time. @param told  gets each attempt as it ends; may be empty.
/// @param interrupted  asked before each attempt; says that the task is to end; may be empty.
/// @throws InputError when a name stands twice, attempts are below 1, or `after_failure` names no
/// step at or before its own.
[[nodiscard]] TaskReport Carry(const std::vector<TaskStep>& steps, const std::function<Time()>& now,
                               const std::function<void(const StepReport&)>& told = {},
                               const std::function<bool()>& interrupted = {});

}  // namespace twin::application
