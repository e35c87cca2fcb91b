#pragma once

#include <limits>
#include <optional>
#include <string>

#include "twin/core/time.h"
#include "twin/loop/deviation.h"

namespace twin::scenario {

/// What a scenario says about how far the arm may be from its target (loop::Deviation) in a motion
/// that ended well. Infinite: as far as it likes. Absent: the default, see DeviationLimit.
struct MaxDeviation {
  std::optional<double> joints;    ///< rad, of any joint
  std::optional<double> position;  ///< m, of the end effector on the interface of poses
  std::optional<double> angle;     ///< rad, of the same
  bool operator==(const MaxDeviation&) const = default;
};

/// The same of one motion; infinite where it is not judged.
struct DeviationLimit {
  double joints = std::numeric_limits<double>::infinity();    ///< rad
  double position = std::numeric_limits<double>::infinity();  ///< m
  double angle = std::numeric_limits<double>::infinity();     ///< rad
};

/// What a motion came to that the robot's own controller should have kept on its path.
struct FollowedMotion {
  std::string name;  ///< empty: the only one
  Time begun{};      ///< of the session
  loop::Deviation deviation;
  DeviationLimit limit;
  bool succeeded = false;  ///< else its failure tells more than its deviation

  [[nodiscard]] bool exceeds() const noexcept { return succeeded && !Excess().empty(); }
  /// By what it is above its limit, for people; empty: by nothing.
  [[nodiscard]] std::string Excess() const;
};

}  // namespace twin::scenario
