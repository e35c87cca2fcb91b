#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "experiment/spectrum.h"
#include "twin/core/joint_vector.h"
#include "twin/experiment/findings.h"

namespace twin::experiment {

/// Samples of a segment of the spectra: 0.98 Hz of resolution at 1 kHz.
inline constexpr std::size_t kTrackingSegment = 1024;

/// What the joints of a run did.
struct TrackingCurves {
  std::array<std::vector<double>, kJoints> dq;  ///< measured, rad/s, at 1 kHz
  std::array<Spectrum, kJoints> spectrum;       ///< of dq
};

/// The runs that are drawn.
struct TrackingRuns {
  std::array<std::vector<double>, kJoints> planned;  ///< velocity, rad/s, at 1 kHz
  TrackingCurves synchronous;                        ///< with the low-pass
  TrackingCurves proposed;
  TrackingCurves filtered;  ///< the proposed with the low-pass
  TrackingCurves quiet{};   ///< synchronous, without timing faults; may be none
};

/// The paper's figure, of joint 1: velocities above, their spectra below.
[[nodiscard]] Figure FirstJointFigure(const TrackingRuns& runs);

/// Velocities of all joints, every tenth cycle.
[[nodiscard]] Figure VelocitiesFigure(const TrackingRuns& runs);

/// Spectra of all joints.
[[nodiscard]] Figure SpectraFigure(const TrackingRuns& runs);

}  // namespace twin::experiment
