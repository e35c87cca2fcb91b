#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "twin/experiment/findings.h"

namespace twin::experiment {

/// What the report tells of how it was made. The same facts and findings give the same bytes.
struct PageFacts {
  std::uint64_t seed = 1;
  int seeds = 20;
  std::string calibration{};  ///< Calibration::hash; empty: it could not be read
  std::string parameters{};   ///< the calibrated loops, as text
  std::string version{};      ///< of the program
  /// Of runs on the wall clock: what kept time, in a line. Empty: the virtual clock, which is the
  /// same on every machine.
  std::string machine{};
  std::string left_out{};  ///< experiments that say nothing more there, in a line; may be empty
};

/// The report: one HTML file that needs no other and no network. On top what became of each
/// experiment, then each with its comparisons and figures, at the end how it was made.
[[nodiscard]] std::string Page(std::span<const Findings> findings, const PageFacts& facts);

/// Whether a text is such a report.
[[nodiscard]] bool IsPage(std::string_view html);

/// The tables that a report names, without their folder; no name leads out of it.
[[nodiscard]] std::vector<std::string> CsvNamesOf(std::string_view html);

/// "<experiment>_<figure>.csv".
[[nodiscard]] std::string CsvName(const Findings& findings, const Figure& figure);

/// What became of an experiment, in a few words: "5 of 6 demands met; 1 not reproduced; 7
/// calibrated", "failed", "nothing demanded".
[[nodiscard]] std::string Outcome(const Findings& findings);

/// Each demand that was missed for no known reason in a line, "RS, d_EXT, max: 1.75 ms; the paper's
/// is 2.174 ms; demanded: within ...". Empty for none.
[[nodiscard]] std::string MissedLines(const Findings& findings);

}  // namespace twin::experiment
