#pragma once

#include <optional>
#include <string>

#include "twin/application/application.h"
#include "twin/plant/contact_watch.h"
#include "twin/run/summary.h"
#include "twin/scenario/scenario.h"

namespace twin::application {

/// What an application's run came to.
struct ApplicationResult {
  TaskResult task_result;
  Evaluation evaluation;
  run::SessionResult session;
  bool interrupted = false;
};

/// "success", "interrupted" or "failed".
[[nodiscard]] std::string OutcomeOf(const ApplicationResult& result);

/// summary.json of an application: what, in lockstep, repeats with scenario and seed, byte by byte.
[[nodiscard]] std::string SummaryJson(const scenario::Scenario& scenario,
                                      const ApplicationResult& result,
                                      const std::optional<plant::ContactWatch>& contacts);

/// The block it ends with on the terminal.
[[nodiscard]] std::string SummaryText(const scenario::Scenario& scenario,
                                      const ApplicationResult& result, const run::WallTimes& times);

}  // namespace twin::application
