#pragma once

#include <array>
#include <filesystem>
#include <vector>

#include "application/pick_evaluation.h"
#include "twin/application/application.h"
#include "twin/core/limits.h"

namespace twin::application {

/// What a log says of the arm over the task, sample by sample, 5 ms apart.
struct PickTrace {
  std::vector<double> t;                 ///< s, of the session
  std::array<std::vector<double>, 3> p;  ///< end effector, measured, m
  std::vector<double> velocity;          ///< largest share of a joint's limit, of dq_d
  std::vector<double> acceleration;      ///< the same of ddq_d
  std::vector<double> jerk;              ///< and of the reference's jerk
  std::vector<double> force;             ///< on the hand, upwards, as the robot estimates it, N
};

/// Shares are the largest since the sample before. @throws as record::LogReader.
[[nodiscard]] PickTrace ReadPickTrace(const std::filesystem::path& log, const JointLimits& limits);

/// Where the end effector was, how much of the limits the reference used, what the hand felt.
/// @param track  of the object; null: nobody knows.
[[nodiscard]] std::vector<report::Figure> PickFigures(const PickTrace& trace,
                                                      const plant::ObjectTrack* track);

}  // namespace twin::application
