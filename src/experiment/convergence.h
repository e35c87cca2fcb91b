#pragma once

#include <string_view>
#include <vector>

#include "twin/experiment/findings.h"
#include "twin/loop/loop_config.h"
#include "twin/scenario/robot_data.h"

namespace twin::experiment {

/// A way of bringing the robot's reference to the source's.
struct ConvergenceWay {
  std::string_view name;
  loop::TickConfig tick;
};

/// Ours (the saturated correction behind the resampler, and the filter), the paper's generator with
/// lambda = 1e-3 and 1e-2, and the client library's limiter on a stream of positions.
[[nodiscard]] std::vector<ConvergenceWay> ConvergenceWays(const scenario::RobotData& robot);

/// What becomes of an offset of joint 1: the robot's reference stands, and the source is ahead.
struct Convergence {
  double time_s = 0;           ///< until the error stays within 1e-4 rad; not a number: never
  double overshoot = 0;        ///< how far it was ahead of the source, as a share of the offset
  double share = 0;            ///< largest share of a limit of velocity, acceleration or jerk
  double lag_s = 0;            ///< of what is followed in the end, behind the source
  double error = 0;            ///< largest in the last second, less that lag, rad
  std::vector<double> errors;  ///< of every cycle, less the lag, rad
};

/// @param offset  of the source from the robot's reference, > 0, rad. @param moves  the source
/// swings by 0.5 rad, and goes ahead with 0.625 rad/s at first; else it stands. @param rest  where
/// the joints are, 7, rad.
[[nodiscard]] Convergence MeasureConvergence(const loop::TickConfig& tick, const JointVector& rest,
                                             double offset, bool moves);

/// Figures of all ways, what ours must keep, and the drawing.
void AddConvergence(const scenario::RobotData& robot, Findings& findings);

}  // namespace twin::experiment
