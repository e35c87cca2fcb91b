#pragma once

#include "twin/experiment/experiment.h"

namespace twin::experiment {

// One function per experiment; those on the wall clock are Experiment::run_on_wall_clock.

/// Table 1: d_EXT and unserved cycles of the bare, the synchronous and the asynchronous loop, their
/// read-to-read intervals, and what determines the unserved share of the synchronous loop.
[[nodiscard]] Findings RunTimings(const Config& config);
[[nodiscard]] Findings RunTimingsOnWallClock(const Config& config);

/// Jitter of the sampling: the jerk it causes, when that aborts, and what helps.
[[nodiscard]] Findings RunJitter(const Config& config);
[[nodiscard]] Findings RunJitterOnWallClock(const Config& config);

/// How much uniform noise on the deposited positions INT bears, raw and through each stage.
[[nodiscard]] Findings RunNoise(const Config& config);

/// The feed-forward of the reference generator, formed at the deposit over the source's own elapsed
/// time, at the deposit over the nominal period, and where commands are consumed.
[[nodiscard]] Findings RunFeedForwardStudy(const Config& config);

/// The paper's figure of position control: one trajectory by the synchronous loop with the client
/// library's low-pass, by the asynchronous loop with the reference generator, and by the latter
/// with the low-pass; the joints' measured velocities and their power spectral density.
[[nodiscard]] Findings RunTracking(const Config& config);
[[nodiscard]] Findings RunTrackingOnWallClock(const Config& config);

/// Delay and smoothness of the rate matcher, by rate and interface.
[[nodiscard]] Findings RunRateMatching(const Config& config);
[[nodiscard]] Findings RunRateMatchingOnWallClock(const Config& config);

/// The correction lambda of the reference generator: how fast an offset decays, and what follows
/// when a source stops, for joints and poses.
[[nodiscard]] Findings RunLambda(const Config& config);

/// Bursts of lost commands: aborted motions and tracking errors of several command chains.
[[nodiscard]] Findings RunLosses(const Config& config);

/// The viability filter and the generator before it: the border of the viable set and its price,
/// the convergence from an offset, and the smoothness of motions behind the asynchronous thread.
[[nodiscard]] Findings RunViability(const Config& config);

}  // namespace twin::experiment
