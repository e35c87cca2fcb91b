#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "experiment/tracking_figures.h"
#include "twin/core/joint_vector.h"
#include "twin/core/time.h"
#include "twin/experiment/experiment.h"
#include "twin/reference/trajectory.h"

namespace twin::experiment {

/// How the trajectory is brought to the robot.
enum class Way : std::uint8_t {
  kSynchronous,  ///< the synchronous loop and the low-pass
  kProposed,     ///< the asynchronous loop and the reference generator
  kFiltered,     ///< the same and the low-pass
  kQuiet,        ///< the synchronous loop and the low-pass, without jitter, drift and overruns
};
inline constexpr std::size_t kWays = 4;

/// Cut-off of the client library's low-pass, where a way has it.
inline constexpr double kLowPassHz = 100;

/// What the spectra hang on and the paper does not tell.
struct TrackingLevels {
  double noise_dq = 1e-3;  ///< standard deviation of the measured velocity, rad/s
  /// Standard deviation of the states' way, 120 us in the mean; absent: as calibrated.
  std::optional<Duration> arrival_spread{};
  /// False: the two clocks are one, and states come half a period after the wake-ups.
  bool has_beat = true;
};

/// Of one run.
struct TrackingOutcome {
  bool succeeded = false;
  double delay_s = 0;
  JointVector rms_delayed{};  ///< error of q once the delay is taken out, rad
  JointVector rms{};          ///< the delay included, rad
  JointVector band{};         ///< power of dq in the band, (rad/s)^2
  double median_band = 0;     ///< the same of joint 1, the median of the segments
  JointVector slope{};        ///< regression of dq on the planned velocity
  TrackingCurves curves;
};

/// The canonical trajectory, as planned. @throws InputError as the scenario.
[[nodiscard]] reference::Trajectory TrackingPlan(const Setting& setting);

/// Runs it and measures. @param run  which of the way's runs: gives its seed and start phase.
/// @throws as RunScenario; RobotFault when it ended too early for a spectrum.
[[nodiscard]] TrackingOutcome MeasureTracking(const Setting& setting,
                                              const reference::Trajectory& plan, Way way, int run,
                                              const TrackingLevels& levels = {});

}  // namespace twin::experiment
