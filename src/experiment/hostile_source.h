#pragma once

#include <vector>

#include "twin/experiment/findings.h"
#include "twin/loop/loop_config.h"
#include "twin/scenario/robot_data.h"

namespace twin::experiment {

/// One cycle of joint 1 behind a source that asks for too much.
struct HostileCycle {
  double t = 0;       ///< s
  double wished = 0;  ///< position of the source, rad
  double q_d = 0;     ///< of the robot's reference, rad
  double dq_d = 0;    ///< rad/s
  double share = 0;   ///< largest of its limits of velocity, acceleration and jerk that is used
  double margin = 0;  ///< of the state answered; 0 without a filter
  bool kept_back = false;
  bool is_lost = false;
};

/// Joint 1 behind a source that swings beyond both ends of its range, at more than its speed, and
/// jumps; and of whose commands 19 in a row are lost, one arrives, 19 are lost and so on, for a
/// second of every three. Each command is taken as it is, whatever it breaks.
[[nodiscard]] std::vector<HostileCycle> RunHostileSource(const loop::TickConfig& tick,
                                                         const JointLimits& limits);

/// The same of ours, and of the paper's generator; and the drawing.
void AddHostileSource(const scenario::RobotData& robot, Findings& findings);

}  // namespace twin::experiment
