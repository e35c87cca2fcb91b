#pragma once

#include <vector>

#include "application/compliance_measures.h"
#include "application/compliance_trace.h"
#include "twin/application/application.h"

namespace twin::application::compliance {

/// The plots for the page; of cases that were made.
[[nodiscard]] std::vector<report::Figure> FiguresOf(const Log& log, const Measures& measures,
                                                    const Settings& settings);

}  // namespace twin::application::compliance
