#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "twin/report/plot.h"

namespace twin::experiment {

/// How a figure of ours stands to what is known of it. Only the first two are demanded.
enum class Verdict : std::uint8_t {
  kPredicted,      ///< follows by mechanism from what was not fitted to it, within what is demanded
  kNotReproduced,  ///< is demanded and does not come out
  kCalibrated,     ///< an input: fitted to what stands beside it
  kReported,       ///< none: nothing is demanded of it, or it is so by arithmetic
};

/// Of something that is demanded.
[[nodiscard]] constexpr Verdict Judge(bool met) noexcept {
  return met ? Verdict::kPredicted : Verdict::kNotReproduced;
}

/// As a report words it: "not reproduced". Thread-safe.
[[nodiscard]] std::string_view Name(Verdict verdict) noexcept;

/// One figure beside the paper's.
struct Comparison {
  std::string quantity{};         ///< "RS, d_EXT, median"
  std::string unit{};             ///< "ms", "%"; empty: a pure number
  std::optional<double> paper{};  ///< absent: the paper has none
  double ours = 0;
  std::optional<double> low{};   ///< over the seeds or runs, if there were several
  std::optional<double> high{};  ///< the same
  std::string demand{};          ///< what must hold, "within 20 % of the paper's"; empty: nothing
  Verdict verdict = Verdict::kReported;
  std::string reason{};  ///< why it is not reproduced, where that is known; shown with that verdict

  /// Not reproduced, and nobody knows why.
  [[nodiscard]] bool is_missed() const noexcept;

  /// ours / paper; absent without the paper's, or when it is 0.
  [[nodiscard]] std::optional<double> ratio() const noexcept;
};

/// A plot of the report: src/report/templates/experiment/EXPERIMENT_FIGURE.gp draws it.
using Figure = report::Figure;

/// What an experiment found.
struct Findings {
  std::string id{};      ///< as the command line and the files' names spell it: "timings"
  std::string title{};   ///< "Loop timings (Table 1)"
  std::string source{};  ///< where in the paper: "Section 2, Table 1"
  /// Its section of the report: src/report/templates/experiment/PAGE.html. Empty: none.
  std::string page{};
  std::map<std::string, std::string> values{};  ///< what the section names, as text
  std::vector<Comparison> comparisons{};
  std::vector<Figure> figures{};
  std::string failure{};  ///< why it could not be done; empty: it was

  /// It was done, and nothing it demands was missed but for a known reason.
  [[nodiscard]] bool succeeded() const noexcept;
};

}  // namespace twin::experiment
