#pragma once

#include <vector>

#include "experiment/stream.h"
#include "twin/experiment/experiment.h"

namespace twin::experiment {

/// What became of some runs of the reference generator with one way to form dq_ext.
struct FeedForwardRuns {
  double aborted = 0;   ///< share of runs
  double jerk = 0;      ///< largest of all, as a share of its limit
  double rms_jerk = 0;  ///< mean over the runs of the worst joint's, the same
};

/// @param jitter_s  of the sampling. @param ppm  >= 0, between the two clocks; 0: the phase of the
/// two loops stays half a cycle. Otherwise every run meets a crossing. @param runs  >= 1.
[[nodiscard]] FeedForwardRuns RunFeedForward(const Setting& setting,
                                             const reference::Trajectory& plan,
                                             const JointLimits& limits, VelocityFrom velocity,
                                             double jitter_s, double ppm, int runs);

/// The feed-forward of the reference generator, formed in three ways: at the deposit over the
/// source's own elapsed time, at the deposit over the nominal period, and where commands are
/// consumed.
[[nodiscard]] Findings RunFeedForwardStudy(const Setting& setting);

}  // namespace twin::experiment
