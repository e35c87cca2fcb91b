#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>

#include "twin/golden/comparison.h"
#include "twin/golden/joint_curves.h"

namespace twin::golden {

/// Report data of one case.
struct CaseResult {
  std::string name;
  std::string run;      ///< scenario, lab, seed: one line for users
  std::string approve;  ///< the command that approves it
  Comparison comparison{};
  Golden golden{};
  Pictures pictures{};
  JointCurves joints{};
};

/// A self-contained HTML page. For each case: the verdict; the gates with values and limits; a
/// slider over the frames with expected, actual and difference (key pictures in full size, others
/// small), swapping the first two under the mouse; the joints with a mark at the frame; and the
/// command that approves the case. The same results give the same bytes.
/// @throws EnvironmentError as report::DrawPlot.
[[nodiscard]] std::string PageOf(std::span<const CaseResult> results);

/// True if a file is a page of PageOf(); false if it cannot be read.
[[nodiscard]] bool IsPage(const std::filesystem::path& file);

/// The results as JUnit XML: one test case each, with the verdict as its failure.
[[nodiscard]] std::string JUnitOf(std::span<const CaseResult> results);

}  // namespace twin::golden
