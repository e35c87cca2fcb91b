#pragma once

#include "experiment/statistics.h"
#include "twin/core/joint_vector.h"
#include "twin/reference/trajectory.h"

namespace twin::experiment {

/// A configuration of loop and command chain.
enum class Setup : std::uint8_t {
  kSynchronous,  ///< the synchronous loop and the low-pass
  kProposed,     ///< the asynchronous loop and the reference generator
  kFiltered,     ///< the proposed setup and the low-pass
  kQuiet,        ///< the synchronous setup without jitter, drift and overruns
};
inline constexpr std::size_t kSetups = 4;

/// Cut-off of the client library's low-pass, where a setup has it.
inline constexpr double kLowPassHz = 100;

/// Influences on the spectra that the paper does not state.
struct TrackingLevels {
  double noise_dq = 1e-3;  ///< standard deviation of the measured velocity, rad/s
  /// Standard deviation of the states' delay, 120 us on average; absent: as calibrated.
  std::optional<Duration> arrival_spread{};
  /// False: both clocks run alike, and states come half a period after the wake-ups.
  bool has_beat = true;
};

/// One run.
struct TrackingOutcome {
  bool succeeded = false;
  double delay_s = 0;
  JointVector rms_delayed{};                      ///< error of q less the delay, rad
  JointVector rms{};                              ///< the delay included, rad
  JointVector band{};                             ///< power of dq in the paper's band, (rad/s)^2
  double median_band = 0;                         ///< of joint 1, the median of the segments
  JointVector slope{};                            ///< regression of dq on the planned velocity
  std::array<std::vector<double>, kJoints> dq{};  ///< measured, rad/s, at 1 kHz
  std::array<Spectrum, kJoints> spectrum{};       ///< of dq
};

/// The canonical trajectory, as planned. @throws InputError as the scenario.
[[nodiscard]] reference::Trajectory TrackingPlan(const Config& config);

/// Runs a setup and measures it. @param run  gives seed and start phase.
/// @throws as RunScenario; RobotFault when it ended too early for a spectrum.
[[nodiscard]] TrackingOutcome MeasureTracking(const Config& config,
                                              const reference::Trajectory& plan, Setup setup,
                                              int run, const TrackingLevels& levels = {});

/// The share of a reference's velocity that the robot's reference follows, at one frequency per
/// joint.
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

/// Measures the followed share: every joint of the ideal plant swings at a frequency of its own,
/// 0.05 to 5 Hz, by the calibrated asynchronous loop with generator and low-pass; sines are fitted
/// to the velocity as deposited (dq_ext of the ticks) and to dq_d of the next cycle, once the start
/// has faded.
[[nodiscard]] FollowedShare MeasureFollowedShare(const Config& config, double low_pass_hz);

/// Adds the noise of the measured velocity, and the spread of the states' arrival at the
/// synchronous loop, that give the paper's ratio of 10 (powers in 20 to 150 Hz, synchronous to
/// proposed, joint 1): from runs at levels of each, with a figure.
void AddLevels(const Config& config, const reference::Trajectory& plan, Findings& findings);

}  // namespace twin::experiment
