#include "twin/application/task.h"

#include <cstddef>
#include <utility>

#include <fmt/format.h>

#include "twin/core/error.h"

namespace twin::application {
namespace {

/// For each step where its failure leads; its own number of steps when nowhere.
std::vector<std::size_t> FallbacksOf(const std::vector<TaskStep>& steps) {
  std::vector<std::size_t> fallbacks(steps.size(), steps.size());
  for (std::size_t i = 0; i < steps.size(); ++i) {
    if (steps[i].attempts < 1) {
      throw InputError(fmt::format("step {}: {} attempts; it takes at least 1", steps[i].name,
                                   steps[i].attempts));
    }
    for (std::size_t j = 0; j < i; ++j) {
      if (steps[j].name != steps[i].name) continue;
      throw InputError(fmt::format("step {} stands twice in a task", steps[i].name));
    }
    if (steps[i].after_failure.empty()) continue;
    for (std::size_t j = 0; j <= i; ++j) {
      if (steps[j].name == steps[i].after_failure) fallbacks[i] = j;
    }
    if (fallbacks[i] == steps.size()) {
      throw InputError(
          fmt::format("step {}: after a failure it goes on at {}, which is no step at "
                      "or before it",
                      steps[i].name, steps[i].after_failure));
    }
  }
  return fallbacks;
}

/// One attempt. @param is_lost  set when the robot is gone or has refused.
StepEnd Try(const TaskStep& step, bool& is_lost) {
  try {
    return step.act();
  } catch (const RobotFault& fault) {
    is_lost = true;
    return {false, fault.what()};
  }
}

}  // namespace

TaskReport Carry(const std::vector<TaskStep>& steps, const std::function<Time()>& now,
                 const std::function<void(const StepReport&)>& told,
                 const std::function<bool()>& interrupted) {
  const std::vector<std::size_t> fallbacks = FallbacksOf(steps);
  std::vector<int> failures(steps.size(), 0);
  TaskReport report;
  for (std::size_t i = 0; i < steps.size();) {
    const TaskStep& step = steps[i];
    if (interrupted && interrupted()) {
      report.failure = fmt::format("interrupted before step {}", step.name);
      return report;
    }
    StepReport attempt{.name = step.name, .attempt = failures[i] + 1, .begun = now()};
    bool is_lost = false;
    StepEnd end = Try(step, is_lost);
    attempt.ended = now();
    attempt.succeeded = end.succeeded;
    attempt.text = std::move(end.text);
    report.steps.push_back(attempt);
    if (told) told(attempt);
    if (attempt.succeeded) {
      ++i;
      continue;
    }
    ++failures[i];
    if (is_lost || failures[i] >= step.attempts || fallbacks[i] == steps.size()) {
      report.failure = fmt::format("step {} failed: {}", step.name, attempt.text);
      if (failures[i] > 1) report.failure += fmt::format(" (attempt {})", failures[i]);
      return report;
    }
    i = fallbacks[i];
  }
  return report;
}

}  // namespace twin::application
