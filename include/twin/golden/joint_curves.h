#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <vector>

#include "twin/core/joint_vector.h"

namespace twin::golden {

/// Where the joints were over a run, thinned out for a plot.
struct JointCurves {
  static constexpr std::size_t kMostPoints = 1200;

  std::vector<double> t;                           ///< s, of the robot's time
  std::array<std::vector<double>, kJoints> q{};    ///< measured, rad, by joint
  std::array<std::vector<double>, kJoints> q_d{};  ///< the reference, rad, by joint
};

/// Reads a log in one pass, keeping each second point whenever there are too many.
/// Threads: one thread. Real-time: no. @throws as record::LogReader.
[[nodiscard]] JointCurves ReadJointCurves(const std::filesystem::path& log);

}  // namespace twin::golden
