#pragma once

#include <nlohmann/json_fwd.hpp>

#include "twin/sweep/merge.h"

namespace twin::sweep {

/// Data of the report's survival curves, `survival` of templates/sweep/report.html; null without a
/// failure.
[[nodiscard]] nlohmann::ordered_json SurvivalOnPage(const Sweep& sweep, const Merged& merged);

}  // namespace twin::sweep
