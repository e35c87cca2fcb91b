#include "twin/application/task.h"

#include <algorithm>
#include <cstddef>
#include <span>
#include <utility>

#include <fmt/format.h>

#include "twin/core/error.h"

namespace twin::application {
namespace {

/// For each step, the index at which the task continues after a failure; steps.size(): it ends.
std::vector<std::size_t> FallbacksOf(const std::vector<TaskStep>& steps) {
  std::vector<std::size_t> fallbacks(steps.size(), steps.size());
  const auto find = [&steps](std::size_t count, const std::string& name) {
    const auto some = std::span(steps).first(count);
    return static_cast<std::size_t>(std::ranges::find(some, name, &TaskStep::name) - some.begin());
  };
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const TaskStep& step = steps[i];
    if (step.attempts < 1) {
      throw InputError(
          fmt::format("step {}: {} attempts; it takes at least 1", step.name, step.attempts));
    }
    if (find(i, step.name) < i) {
      throw InputError(fmt::format("step {} stands twice in a task", step.name));
    }
    if (step.after_failure.empty()) continue;
    fallbacks[i] = find(i + 1, step.after_failure);
    if (fallbacks[i] <= i) continue;
    throw InputError(
        fmt::format("step {}: after a failure it goes on at {}, which is no step at or before it",
                    step.name, step.after_failure));
  }
  return fallbacks;
}

/// One attempt. @param is_lost  set when the step threw RobotFault.
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
                 const std::function<void(const StepReport&)>& on_attempt,
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
    if (on_attempt) on_attempt(attempt);
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
