#pragma once

#include <optional>

#include "cli/commands.h"
#include "cli/exit_code.h"
#include "twin/fci/capture.h"
#include "twin/run/run.h"
#include "twin/scenario/scenario.h"

namespace twin::cli {

/// Runs a scenario that names an application, and writes what came of it: as a run's results, and
/// the application's page and pictures.
/// @param capture  is made when the flags want one. @throws twin::Error; Interrupted.
[[nodiscard]] ExitCode RunApplication(const scenario::Scenario& scenario, const RunFlags& flags,
                                      const Host& host, const run::Catalogue& catalogue,
                                      std::optional<fci::Capture>& capture);

}  // namespace twin::cli
