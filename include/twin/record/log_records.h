#pragma once

#include <cstdint>
#include <optional>
#include <string>

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

}  // namespace twin::record
