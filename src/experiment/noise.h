#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

#include "experiment/stream.h"
#include "twin/experiment/experiment.h"

namespace twin::experiment {

/// What a noisy source goes through.
enum class NoiseStage : std::uint8_t {
  kRaw,            ///< nothing
  kLimiter,        ///< libfranka's rate limiter
  kLowPass,        ///< libfranka's low-pass, 100 Hz
  kRateMatching,   ///< a source of 125 Hz and the moving average over 8 cycles
  kGenerator,      ///< the reference generator; the velocity is formed from the noisy positions
  kGivenVelocity,  ///< the same with a velocity without noise, by the source
};
inline constexpr std::array<std::string_view, 6> kNoiseStages{
    "raw",
    "rate limiter",
    "low-pass 100 Hz",
    "rate matching, source of 125 Hz",
    "reference generator",
    "reference generator, velocity given"};
/// @returns a stream without noise through it.
[[nodiscard]] Stream StreamThrough(NoiseStage stage, const scenario::RobotData& robot);

/// What noise of some amplitudes does in 1 s of motion.
struct NoiseCurves {
  std::vector<double> amplitude;  ///< rad, rising
  int runs = 0;                   ///< of each
  /// Share of runs that the joint alone would have aborted, [joint][amplitude].
  std::array<std::vector<double>, kJoints> aborted;
  std::array<std::vector<double>, kJoints> rms_jerk;  ///< mean over the runs, of its limit
};
/// All joints move gently, 2 % of their acceleration limits; each has its noise, and each is judged
/// for itself. @param runs  of each amplitude, >= 1.
[[nodiscard]] NoiseCurves MeasureNoise(const Setting& setting, const scenario::RobotData& robot,
                                       NoiseStage stage, const std::vector<double>& amplitude,
                                       int runs);

/// Amplitude at which half of the runs abort, between two amplitudes on a logarithmic scale;
/// infinite if so many never do. @param joint  from 0.
[[nodiscard]] double HalfAborted(const NoiseCurves& curves, std::size_t joint);

/// How much uniform noise on the deposited positions INT bears, raw and through each stage.
[[nodiscard]] Findings RunNoise(const Setting& setting);

}  // namespace twin::experiment
