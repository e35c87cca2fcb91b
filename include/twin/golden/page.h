#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>

#include "twin/golden/comparison.h"
#include "twin/golden/joint_curves.h"

namespace twin::golden {

/// What is told of one case.
struct CaseResult {
  std::string name;
  std::string run;      ///< scenario, lab, seed: a line for people
  std::string approve;  ///< the command that approves it
  Comparison comparison{};
  Golden golden{};
  Pictures pictures{};
  JointCurves joints{};
};

/// One HTML page that needs no other file and no network: of each case the verdict, the gates with
/// values and limits, expected, actual and difference of every frame (key pictures whole, others
/// small) by a slider, the two changing places under the mouse, the joints under them with a mark
/// at the frame, and the command that approves it. The same results give the same bytes.
/// @throws EnvironmentError as report::DrawChart.
[[nodiscard]] std::string PageOf(std::span<const CaseResult> results);

/// Whether a file is a page that PageOf() made; one that cannot be read is none.
[[nodiscard]] bool IsPage(const std::filesystem::path& file);

/// The same for machines, as JUnit's XML: a test case each, whose failure is the verdict.
[[nodiscard]] std::string JUnitOf(std::span<const CaseResult> results);

}  // namespace twin::golden
