#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "twin/experiment/experiment.h"

namespace twin::experiment {

/// How a report was made. The same facts and findings give the same bytes.
struct PageFacts {
  std::uint64_t seed = 1;
  int seeds = 20;
  std::string calibration{};  ///< Calibration::hash; empty: unreadable
  std::string parameters{};   ///< the calibrated loops, as text
  std::string version{};      ///< of the program
  /// The machine of runs on the wall clock, in a line. Empty: the virtual clock, which is the same
  /// on every machine.
  std::string machine{};
  std::string left_out{};  ///< experiments that run in lockstep only, in a line; may be empty
};

/// The report: one HTML file that needs no other file and no network. It shows the outcome of every
/// experiment, then each with its comparisons and figures, and last how the report was made.
[[nodiscard]] std::string Page(std::span<const Findings> findings, const PageFacts& facts);

/// Whether a text is such a report.
[[nodiscard]] bool IsPage(std::string_view html);

/// The tables that a report names, without their folder; no name contains a '/'.
[[nodiscard]] std::vector<std::string> CsvNamesOf(std::string_view html);

/// findings.json: every figure beside the paper's, with its verdict. @param calibration
/// Calibration::hash.
[[nodiscard]] std::string FindingsJson(std::span<const Findings> findings, int seeds,
                                       std::string_view calibration);

/// "<experiment>_<figure>.csv".
[[nodiscard]] std::string CsvName(const Findings& findings, const Figure& figure);

/// The outcome of an experiment in a few words: "5 of 6 demands met; 1 not reproduced; 7
/// calibrated", "failed", "nothing demanded".
[[nodiscard]] std::string Outcome(const Findings& findings);

/// A line for each demand missed for an unknown reason: "RS, d_EXT, max: 1.75 ms; the paper's is
/// 2.174 ms; demanded: within ...". Empty without any.
[[nodiscard]] std::string MissedLines(const Findings& findings);

}  // namespace twin::experiment
