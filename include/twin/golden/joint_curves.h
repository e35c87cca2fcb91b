#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <vector>

#include "twin/core/joint_vector.h"

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

}  // namespace twin::golden
