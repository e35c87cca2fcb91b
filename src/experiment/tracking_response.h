#pragma once

#include <array>
#include <complex>

#include "twin/core/joint_vector.h"
#include "twin/experiment/experiment.h"

namespace twin::experiment {

/// What the robot's reference makes of a reference's velocity, at one frequency each joint.
struct FollowedShare {
  std::array<double, kJoints> frequency_hz{};
  std::array<std::complex<double>, kJoints> measured{};
  std::array<std::complex<double>, kJoints> expected{};

  /// Largest |measured - expected| / |expected|.
  [[nodiscard]] double largest_error() const noexcept;
};

/// g (s + lambda/T) / (s + g lambda/T) at s = 2 pi j f, T = 1 ms: the reference generator with a
/// first-order low-pass of gain g behind it. Source: the paper's section on reference generation.
[[nodiscard]] std::complex<double> LowPassedResponse(double gain, double lambda,
                                                     double frequency_hz) noexcept;

/// Measures it: every joint of the ideal plant swings at a frequency of its own, 0.05 to 5 Hz, by
/// the calibrated asynchronous loop with generator and low-pass; sines are fitted to the velocity
/// as deposited (dq_ext of the ticks) and to dq_d of the cycle after, once the start has faded.
[[nodiscard]] FollowedShare MeasureFollowedShare(const Setting& setting, double low_pass_hz);

/// The figure of it.
[[nodiscard]] Figure FollowedShareFigure(const FollowedShare& share, double gain, double lambda);

}  // namespace twin::experiment
