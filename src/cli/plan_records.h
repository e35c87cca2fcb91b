#pragma once

#include "twin/application/application.h"
#include "twin/record/log_records.h"
#include "twin/run/run.h"
#include "twin/scenario/scenario.h"

namespace twin::cli {

/// What an application planned and carried out, for its log.
[[nodiscard]] record::PlanRecord PlanOf(const application::Snapshot& snapshot);

/// The same of a planned motion, from its run's beginning to the end. @pre the run is over.
[[nodiscard]] record::PlanRecord PlanOf(const run::Run& run, const scenario::Scenario& scenario,
                                        Time end);

}  // namespace twin::cli
