#pragma once

#include <string>
#include <string_view>

#include <fmt/format.h>

#include "report/run_data.h"

namespace twin::report {

// Colours that differ for colour-blind readers and in greyscale.
inline constexpr std::string_view kReferenceColour = "#0b3c6f";  ///< dark blue: q_d and the like
inline constexpr std::string_view kMeasuredColour = "#f0a030";   ///< amber: measured quantities
inline constexpr std::string_view kHeldColour = "#d1495b";       ///< red

/// `text` as a gnuplot string: quoted, without control characters.
[[nodiscard]] std::string Quote(std::string_view text);

/// "name of the scenario: what", with the error that ended the motion and a note if the log is
/// truncated.
[[nodiscard]] std::string Title(const RunData& run, std::string_view what);

}  // namespace twin::report
