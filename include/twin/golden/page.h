#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "twin/core/joint_vector.h"
#include "twin/golden/comparison.h"

namespace twin::golden {

/// Joint positions over a run, thinned for a plot.
struct JointCurves {
  static constexpr std::size_t kMostPoints = 1200;

  std::vector<double> t;                           ///< s, robot time
  std::array<std::vector<double>, kJoints> q{};    ///< measured, rad, by joint
  std::array<std::vector<double>, kJoints> q_d{};  ///< the reference, rad, by joint
};

/// Reads a log in one pass, halving the number of points whenever it exceeds the limit.
/// Threads: one thread. Real-time: no. @throws as record::LogReader.
[[nodiscard]] JointCurves ReadJointCurves(const std::filesystem::path& log);

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
