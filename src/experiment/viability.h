#pragma once

#include "experiment/stream.h"
#include "twin/reference/viable_axis.h"

namespace twin::experiment {

/// The highest velocity from which a joint's limits can be kept at all times.
/// @param q, ddq  rad, rad/s^2. @returns rad/s; 0 without such a velocity.
[[nodiscard]] double HighestSpeed(const reference::ViableAxis& axis, double q, double ddq);

/// The least distance to the upper end of the range at which full speed, without acceleration, is
/// viable, rad.
[[nodiscard]] double StoppingDistance(const reference::ViableAxis& axis);

/// Time from rest until close to a goal when the joint always asks for the largest jerk and the
/// filter, whose range ends at the goal, stops it there. Nothing is lost; with lost = 0 no motion
/// is faster.
/// @param bounds  of the joint. @param distance  rad, below its range. @param close  rad.
/// @returns s.
[[nodiscard]] double RestToRestTime(const reference::AxisBounds& bounds, int lost, double distance,
                                    double close = 1e-3);

/// Adds the borders of the viable set and the price of tolerating losses: figures and demands.
/// @param bounds  of the joints.
void AddViableSet(const std::vector<reference::AxisBounds>& bounds, Findings& findings);

/// A command chain under comparison.
struct Chain {
  std::string_view name;
  loop::TickConfig tick;
};

/// A generator for the limits of the Panda; the viability filter is behind the rejoining one.
[[nodiscard]] loop::TickConfig TickBehind(loop::Generator generator,
                                          const scenario::RobotData& robot, double lambda = 1e-3);

/// Ours (the saturated correction behind the resampler, and the filter), the paper's generator with
/// lambda = 1e-3 and 1e-2, and the client library's limiter on a stream of positions.
[[nodiscard]] std::vector<Chain> ComparedChains(const scenario::RobotData& robot);

/// Convergence from an offset of joint 1: the robot's reference stands, and the source is ahead.
struct Convergence {
  double time_s = 0;           ///< until the error stays within 1e-4 rad; NaN: never
  double overshoot = 0;        ///< farthest ahead of the source, as a share of the offset
  double share = 0;            ///< largest share of a limit of velocity, acceleration or jerk
  double lag_s = 0;            ///< behind the source at the end
  double error = 0;            ///< largest in the last second, less that lag, rad
  std::vector<double> errors;  ///< of every cycle, less the lag, rad
};

/// @param rest  initial joints, 7, rad. @param offset  of the source from the robot's reference, >
/// 0, rad. @param moves  the source swings by 0.5 rad, at first ahead with 0.625 rad/s; else it
/// stands.
[[nodiscard]] Convergence MeasureConvergence(const loop::TickConfig& tick, const JointVector& rest,
                                             double offset, bool moves);

/// Adds the convergence of every chain, with the demands on ours and a figure.
void AddConvergence(const scenario::RobotData& robot, Findings& findings);

/// One cycle of joint 1 behind a source that exceeds the limits.
struct HostileCycle {
  double t = 0;       ///< s
  double wished = 0;  ///< position of the source, rad
  double q_d = 0;     ///< of the robot's reference, rad
  double dq_d = 0;    ///< rad/s
  double share = 0;   ///< largest share of a limit of velocity, acceleration or jerk
  double margin = 0;  ///< of the answered state; 0 without a filter
  bool kept_back = false;
  bool is_lost = false;
};

/// Joint 1 behind a source that swings beyond both ends of its range, faster than its limit, and
/// jumps; for a second of every three, 19 of 20 of its commands are lost. The robot takes each
/// other command, whatever limit it breaks.
[[nodiscard]] std::vector<HostileCycle> RunHostileSource(const loop::TickConfig& tick);

/// Adds the hostile source behind every chain, with a figure of ours.
void AddHostileSource(const scenario::RobotData& robot, Findings& findings);

}  // namespace twin::experiment
