#pragma once

#include <limits>
#include <optional>
#include <string>

#include "twin/core/time.h"
#include "twin/loop/deviation.h"

namespace twin::scenario {

/// What a scenario says about how far the arm may be from its target (loop::Deviation) in a motion
/// that ended well. Infinite: as far as it likes. Absent: the default, see run::LimitOf.
struct MaxDeviation {
  std::optional<double> joints;    ///< rad, of any joint
  std::optional<double> position;  ///< m, of the end effector on the interface of poses
  std::optional<double> angle;     ///< rad, of the same
  bool operator==(const MaxDeviation&) const = default;
};

}  // namespace twin::scenario
