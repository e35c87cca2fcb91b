#pragma once

#include "twin/experiment/experiment.h"

namespace twin::experiment {

// Experiment::run of each of Experiments(), and their run_on_wall_clock.

/// d_EXT and unserved cycles of the three loops, their read-to-read intervals, and what determines
/// the unserved share of the synchronous loop.
[[nodiscard]] Findings RunTimings(const Config& config);
[[nodiscard]] Findings RunTimingsOnWallClock(const Config& config);
/// The jerk that jitter causes, when it aborts, and the remedies.
[[nodiscard]] Findings RunJitter(const Config& config);
[[nodiscard]] Findings RunJitterOnWallClock(const Config& config);
/// Uniform noise on the deposited positions that INT bears, raw and through each stage.
[[nodiscard]] Findings RunNoise(const Config& config);
/// The velocity formed at the deposit over the source's own elapsed time, at the deposit over the
/// nominal period, and where commands are consumed.
[[nodiscard]] Findings RunFeedForwardStudy(const Config& config);
/// One trajectory by the synchronous loop with the client library's low-pass, by the asynchronous
/// loop with the reference generator, and by the latter with the low-pass: the joints' measured
/// velocities and their power spectral density.
[[nodiscard]] Findings RunTracking(const Config& config);
[[nodiscard]] Findings RunTrackingOnWallClock(const Config& config);
/// Delay and smoothness of the rate matcher, by rate and interface.
[[nodiscard]] Findings RunRateMatching(const Config& config);
[[nodiscard]] Findings RunRateMatchingOnWallClock(const Config& config);
/// Decay of an offset, and the effect of a source that stops, for joints and poses.
[[nodiscard]] Findings RunLambda(const Config& config);
/// Aborted motions and tracking errors of several command chains.
[[nodiscard]] Findings RunLosses(const Config& config);
/// The border of the viable set and its price, the convergence from an offset, and the smoothness
/// of motions behind the asynchronous thread.
[[nodiscard]] Findings RunViability(const Config& config);

}  // namespace twin::experiment
