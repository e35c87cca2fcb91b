#pragma once

#include <filesystem>
#include <string>

#include "twin/sweep/merge.h"

namespace twin::sweep {

/// The report: a heat map of two axes, survival curves, the points with their intervals, the worst
/// failures and the commands that repeat them. One HTML file that holds everything.
[[nodiscard]] std::string PageOf(const Sweep& sweep, const Merged& merged,
                                 const std::filesystem::path& out);

}  // namespace twin::sweep
