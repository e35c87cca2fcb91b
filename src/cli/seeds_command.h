#pragma once

#include "cli/commands.h"
#include "cli/exit_code.h"
#include "twin/run/run.h"
#include "twin/scenario/scenario.h"

namespace twin::cli {

/// Carries an application out for many seeds, in lockstep, and writes a page, a table of all and a
/// summary. @returns kFailed when less than the wanted share succeeded.
/// @throws twin::Error; Interrupted.
[[nodiscard]] ExitCode RunManySeeds(const scenario::Scenario& scenario, const RunFlags& flags,
                                    const Host& host, const run::Catalogue& catalogue);

}  // namespace twin::cli
