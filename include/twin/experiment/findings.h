#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "twin/report/plot.h"

namespace twin::experiment {

/// How a figure of ours compares with what is known about it. Only the first two have a demand.
enum class Verdict : std::uint8_t {
  kPredicted,      ///< follows by mechanism from inputs not fitted to it, and meets its demand
  kNotReproduced,  ///< misses its demand
  kCalibrated,     ///< an input, fitted to the paper's figure
  kReported,       ///< has no demand, or holds by arithmetic
};

/// The verdict on a figure with a demand.
[[nodiscard]] constexpr Verdict Judge(bool met) noexcept {
  return met ? Verdict::kPredicted : Verdict::kNotReproduced;
}

/// The verdict in a report's words: "not reproduced". Thread-safe.
[[nodiscard]] std::string_view Name(Verdict verdict) noexcept;

/// Mean, smallest and largest of some values; all 0 without values.
struct Spread {
  double mean = 0;
  double low = 0;
  double high = 0;
};

/// One figure beside the paper's.
struct Comparison {
  std::string quantity{};         ///< "RS, d_EXT, median"
  std::string unit{};             ///< "ms", "%"; empty: a pure number
  std::optional<double> paper{};  ///< absent: the paper has none
  double ours = 0;
  std::optional<double> low{};   ///< smallest over the seeds or runs; absent for a single value
  std::optional<double> high{};  ///< largest over the same
  std::string demand{};          ///< "within 20 % of the paper's"; empty: none
  Verdict verdict = Verdict::kReported;
  std::string reason{};  ///< why it is not reproduced, where known; shown with that verdict

  /// Sets the paper's figure.
  Comparison& Paper(double value);
  /// Sets the demand and its verdict; an empty text sets no demand.
  Comparison& Demand(std::string text, bool met);

  /// Not reproduced, for an unknown reason.
  [[nodiscard]] bool is_missed() const noexcept;

  /// ours / paper; absent without the paper's figure, or when that is 0.
  [[nodiscard]] std::optional<double> ratio() const noexcept;
};

/// A plot of the report: src/report/templates/experiment/EXPERIMENT_FIGURE.gp draws it.
using Figure = report::Figure;

/// The results of an experiment.
struct Findings {
  std::string id{};      ///< the spelling of the command line and of file names: "timings"
  std::string title{};   ///< "Loop timings (Table 1)"
  std::string source{};  ///< place in the paper: "Section 2, Table 1"
  /// Its section of the report: src/report/templates/experiment/PAGE.html. Empty: none.
  std::string page{};
  std::map<std::string, std::string> values{};  ///< texts of the section, by name
  std::vector<Comparison> comparisons{};
  std::vector<Figure> figures{};
  std::string failure{};  ///< why the experiment failed; empty: it completed

  /// Appends a figure of ours. @returns it, until the next call.
  Comparison& Add(std::string quantity, std::string unit, double ours);
  /// Appends a mean with its range. @returns it, until the next call.
  Comparison& Add(std::string quantity, std::string unit, const Spread& spread);

  /// It completed, and missed no demand for an unknown reason.
  [[nodiscard]] bool succeeded() const noexcept;
};

}  // namespace twin::experiment
