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

/// What the robot of a run was held to. Valid.
struct RunLimits {
  JointLimits joints;
  CartesianLimits cartesian;
};

/// What a log says about the run it belongs to.
struct RunInfo {
  std::string scenario;               ///< name of the scenario
  std::uint64_t seed = 0;             ///< of all random numbers
  std::string version;                ///< of panda-twin
  std::string drive;                  ///< "lockstep", "realtime" or "remote"
  std::string scenario_yaml;          ///< text of the scenario file
  std::optional<RunLimits> limits{};  ///< absent: not known
};

/// Something that happened, in words: a mode change, an error, a recovery.
struct EventRecord {
  Time at{};
  std::string kind;  ///< one word, such as "mode", "error", "recovery"
  std::string text;
};

/// A motion that was planned and then carried out: what pictures show of it beforehand.
struct PlanRecord {
  static constexpr std::size_t kMostPoints = 400;

  std::string id;                             ///< letters, digits, '_'
  std::string caption;                        ///< one sentence
  Time from{};                                ///< planned
  Time until{};                               ///< done
  std::optional<JointVector> q{};             ///< of the arm in the end, rad; absent: it stays
  std::vector<Vector3> way{};                 ///< of the end effector, base frame, m
  std::string object{};                       ///< body that is carried; empty: none
  Transform O_T_object = kIdentityTransform;  ///< where that should come to; of an object alone
};

}  // namespace twin::record
