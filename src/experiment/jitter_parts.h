#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

#include "experiment/stream.h"
#include "twin/experiment/findings.h"

namespace twin::experiment {

/// What stands between a jittered source and the robot.
enum class Remedy : std::uint8_t {
  kNone,       ///< the sampled positions go out as they are
  kLimiter,    ///< libfranka's rate limiter
  kLowPass,    ///< libfranka's low-pass, 100 Hz
  kRobotTime,  ///< sampled at the robot's own time
  kGenerator,  ///< the reference generator
};
inline constexpr std::array<std::string_view, 5> kRemedyNames{
    "raw", "rate limiter", "low-pass 100 Hz", "INT timestamps", "reference generator"};
/// @returns a 1 kHz stream without jitter behind it.
[[nodiscard]] Stream StreamBehind(Remedy remedy, const scenario::RobotData& robot);

/// Jerk that jitter makes, as INT reconstructs it and by formula. T the period of 1 ms,
///   position: dq*((k - 1.5) T) D3 dt(k) / T^3,   velocity: ddq*((k - 1) T) D2 dt(k) / T^2,
/// D2 and D3 the second and third backward difference, both derivatives in the middle of the
/// samples that make the difference.
struct JitterJerk {
  std::vector<double> t{};  ///< s
  std::array<std::vector<double>, kJoints>
      measured{};  ///< of the jittered less of the exact stream
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
[[nodiscard]] AbortMap MapAborts(const Setting& setting, const scenario::RobotData& robot,
                                 const std::vector<double>& jitter_us,
                                 const std::vector<double>& speed, int runs);

/// What a pace of the brisk trajectory makes of the reference generator's output.
struct Pace {
  double acceleration = 0;  ///< largest, as a share of its limit
  double jerk = 0;          ///< largest of all runs, the same
  double aborted = 0;       ///< share of runs
};
/// Progress from 0.8 to 1.
[[nodiscard]] std::vector<Pace> FindEnd(const Setting& setting, const StreamSetting& streams,
                                        const std::vector<double>& shares, int runs);

/// Where the line through the paces first meets jerk 1; NaN if it does not.
[[nodiscard]] double ShareAtLimit(const std::vector<Pace>& paces) noexcept;

/// The phase against the robot's cycles with which a source `ppm` fast crosses them at a time
/// chosen at random within the plan. @param ppm  > 0.
[[nodiscard]] Duration CrossingPhase(const reference::Trajectory& plan, double ppm, double choice);

/// Samples of a raw stream, displaced and as INT reconstructs them.
[[nodiscard]] Figure SamplesFigure(const scenario::RobotData& robot, std::uint64_t seed);
[[nodiscard]] Figure JitterJerkFigure(const JitterJerk& position, const JitterJerk& velocity);
[[nodiscard]] Figure AbortMapFigure(const AbortMap& map, const JointLimits& limits);
[[nodiscard]] Figure EndFigure(const std::vector<Pace>& paces, const JointLimits& limits);

}  // namespace twin::experiment
