#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

#include "experiment/stream.h"

namespace twin::experiment {

/// The paper's jitter, s.
inline constexpr double kPaperJitter = 4e-6;

/// Of the first remedies, which experiment jitter compares.
inline constexpr std::array<std::string_view, 5> kRemedyNames{
    "raw", "rate limiter", "low-pass 100 Hz", "INT timestamps", "reference generator"};

/// Jerk caused by jitter, as INT reconstructs it and by formula. T the period of 1 ms,
///   position: dq*((k - 1.5) T) D3 dt(k) / T^3,   velocity: ddq*((k - 1) T) D2 dt(k) / T^2,
/// D2 and D3 the second and third backward difference, both derivatives in the middle of the
/// samples that make the difference.
struct JitterJerk {
  std::vector<double> t{};                              ///< s
  std::array<std::vector<double>, kJoints> measured{};  ///< of the jittered less the exact stream
  std::array<std::vector<double>, kJoints> formula{};
  double residual = 0;  ///< RMS of their difference over all joints and samples / that of formula
  double ratio = 0;     ///< RMS of measured / RMS of formula
};
[[nodiscard]] JitterJerk JerkOfJitter(const reference::Trajectory& plan, const JointLimits& limits,
                                      control::CommandInterface interface, double jitter_s,
                                      std::uint64_t seed);

/// Probability of an abort within 1 s of motion.
struct AbortMap {
  std::vector<double> jitter_us{};
  std::vector<double> speed{};  ///< peak of joint 1, rad/s
  int runs = 0;                 ///< of each place
  /// By Remedy, [speed * jitter_us.size() + jitter].
  std::array<std::vector<double>, kRemedyNames.size()> probability{};
};
/// @param runs  of each place, >= 1. Progress from 0.3 to 0.8.
[[nodiscard]] AbortMap MapAborts(const Config& config, const scenario::RobotData& robot,
                                 const std::vector<double>& jitter_us,
                                 const std::vector<double>& speed, int runs);

/// The reference generator's output at one pace of the brisk trajectory.
struct PaceResult {
  double acceleration = 0;  ///< largest, as a share of its limit
  double jerk = 0;          ///< largest of all runs, as a share of its limit
  double aborted = 0;       ///< share of runs
};
/// Progress from 0.8 to 1.
[[nodiscard]] std::vector<PaceResult> MeasurePaces(const Config& config, const StreamInputs& inputs,
                                                   const std::vector<double>& shares, int runs);

/// The acceleration at which the line through the results first meets jerk 1; NaN if it does not.
[[nodiscard]] double ShareAtLimit(const std::vector<PaceResult>& paces) noexcept;

/// Samples of a raw stream, displaced and as INT reconstructs them.
[[nodiscard]] Figure SamplesFigure(const scenario::RobotData& robot, std::uint64_t seed);
[[nodiscard]] Figure JitterJerkFigure(const JitterJerk& position, const JitterJerk& velocity);
[[nodiscard]] Figure AbortMapFigure(const AbortMap& map, const JointLimits& limits);
[[nodiscard]] Figure EndFigure(const std::vector<PaceResult>& paces, const JointLimits& limits);

/// Effect of noise of several amplitudes in 1 s of motion.
struct NoiseCurves {
  std::vector<double> amplitude;  ///< rad, rising
  int runs = 0;                   ///< of each
  /// Share of runs that the joint alone would have aborted, [joint][amplitude].
  std::array<std::vector<double>, kJoints> aborted;
  std::array<std::vector<double>, kJoints> rms_jerk;  ///< mean over the runs, of its limit
};
/// All joints move gently, at 2 % of their acceleration limits; each has its noise, and each is
/// judged on its own. @param runs  of each amplitude, >= 1. Progress from `from` to `to`.
[[nodiscard]] NoiseCurves MeasureNoise(const Config& config, const scenario::RobotData& robot,
                                       Remedy remedy, const std::vector<double>& amplitude,
                                       int runs, double from = 0, double to = 1);

/// The amplitude at which half of the runs abort, between two amplitudes on a logarithmic scale;
/// infinite without such an amplitude. @param joint  from 0.
[[nodiscard]] double HalfAborted(const NoiseCurves& curves, std::size_t joint);

/// Runs of the reference generator with dq_ext formed in one manner.
struct FeedForwardRuns {
  double aborted = 0;   ///< share of runs
  double jerk = 0;      ///< largest of all, as a share of its limit
  double rms_jerk = 0;  ///< mean over the runs of the worst joint's, as a share of its limit
};

/// @param jitter_s  of the sampling. @param ppm  >= 0, between the two clocks; 0: the phase of the
/// two loops stays half a cycle. Otherwise every run meets a crossing. @param runs  >= 1.
[[nodiscard]] FeedForwardRuns RunFeedForward(const Config& config,
                                             const reference::Trajectory& plan,
                                             const JointLimits& limits, VelocityFrom velocity,
                                             double jitter_s, double ppm, int runs);

}  // namespace twin::experiment
