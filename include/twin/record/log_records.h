#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "twin/core/joint_vector.h"
#include "twin/core/limits.h"
#include "twin/core/time.h"

namespace twin::record {

/// Limits of a run's robot. Valid.
struct RunLimits {
  JointLimits joints;
  CartesianLimits cartesian;
};

/// Description of a log's run.
struct RunInfo {
  std::string scenario;               ///< name of the scenario
  std::uint64_t seed = 0;             ///< of all random numbers
  std::string version;                ///< panda-twin's
  std::string drive;                  ///< "lockstep", "realtime" or "remote"
  std::string scenario_yaml;          ///< text of the scenario file
  std::optional<RunLimits> limits{};  ///< nullopt: not known
};

/// An event as text: a mode change, an error, a recovery.
struct EventRecord {
  Time at{};
  std::string kind;  ///< one word, such as "mode", "error", "recovery"
  std::string text;
};

/// A planned and executed motion, for display before it is executed.
struct PlanRecord {
  static constexpr std::size_t kMostPoints = 400;

  std::string id;                             ///< letters, digits, '_'
  std::string caption;                        ///< one sentence
  Time from{};                                ///< time of planning
  Time until{};                               ///< end of execution
  std::optional<JointVector> q{};             ///< the arm's goal, rad; nullopt: it stays
  std::vector<Vector3> path{};                ///< path of the end effector, base frame, m
  std::string object{};                       ///< body that the arm carries; empty: none
  Transform O_T_object = kIdentityTransform;  ///< the object's goal; only with an object
};

}  // namespace twin::record
