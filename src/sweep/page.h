#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "twin/sweep/merge.h"

namespace twin::sweep {

/// At most ten failures: those that ended farthest from their goal.
[[nodiscard]] std::vector<const Row*> WorstOf(const Merged& merged);

/// The report: a heat map of two axes, the points with their intervals, the worst failures and the
/// commands that repeat them. One HTML file that holds everything.
[[nodiscard]] std::string PageOf(const Sweep& sweep, const Merged& merged,
                                 const std::filesystem::path& out);

}  // namespace twin::sweep
