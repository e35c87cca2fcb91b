#include "experiment/tracking_sensitivity.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>
#include <vector>

#include "experiment/runs.h"
#include "experiment/tracking_runs.h"
#include "twin/core/error.h"

namespace twin::experiment {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kPaperRatio = 10;
constexpr std::array<double, 4> kNoises{1, 4, 8, 12};            // mrad/s
constexpr std::array<double, 6> kSpreads{0.3, 1, 3, 6, 10, 30};  // us

/// Ratios at the levels tried; not a number where a run did not reach its goal.
struct Curve {
  std::vector<double> x;
  std::vector<double> ratio;
};

/// Power of joint 1 in the band; not a number when the robot ended the motion.
double PowerOf(const Setting& setting, const reference::Trajectory& plan, Way way,
               const TrackingLevels& levels) {
  try {
    const TrackingOutcome outcome = MeasureTracking(setting, plan, way, 0, levels);
    return outcome.succeeded ? outcome.band[0] : kNaN;
  } catch (const RobotFault&) {
    ThrowIfInterrupted(setting);
    return kNaN;
  }
}

/// Where the ratio first is the paper's, between two levels, both by their logarithms.
double FirstAtPapersRatio(const Curve& curve) {
  for (std::size_t i = 1; i < curve.x.size(); ++i) {
    const double a = curve.ratio[i - 1];
    const double b = curve.ratio[i];
    if (!(std::min(a, b) < kPaperRatio && std::max(a, b) >= kPaperRatio)) continue;
    const double way = std::log(kPaperRatio / a) / std::log(b / a);
    return curve.x[i - 1] * std::pow(curve.x[i] / curve.x[i - 1], way);
  }
  return kNaN;
}

/// The same of noise, which is in both loops: ratio - 1 goes with 1 / noise^2. From the last level
/// at which both reached their goal.
double NoiseAtPapersRatio(const Curve& noise, double& last) {
  double at = kNaN;
  for (std::size_t i = 0; i < noise.x.size(); ++i) {
    if (!std::isfinite(noise.ratio[i])) break;
    last = noise.x[i];
    at = last * std::sqrt((noise.ratio[i] - 1) / (kPaperRatio - 1));
  }
  return at;
}

Figure LevelsFigure(const Curve& noise, const Curve& beat, const Curve& one_clock) {
  Figure figure{.id = "levels",
                .columns =
                    "varied: 0 noise [mrad/s]; 1 spread with a beat [us]; 2 spread without "
                    "[us],value,ratio"};
  double kind = 0;
  for (const Curve* curve : {&noise, &beat, &one_clock}) {
    for (std::size_t i = 0; i < curve->x.size(); ++i) {
      figure.rows.push_back({kind, curve->x[i], curve->ratio[i]});
    }
    ++kind;
  }
  return figure;
}

}  // namespace

void AddLevels(const Setting& setting, const reference::Trajectory& plan, double from,
               Findings& findings) {
  Curve noise{{kNoises.begin(), kNoises.end()}, std::vector<double>(kNoises.size())};
  Curve beat{{kSpreads.begin(), kSpreads.end()}, std::vector<double>(kSpreads.size())};
  Curve one_clock = beat;
  std::vector<double> proposed(kNoises.size());
  const auto measure = [&](std::vector<double>& to, std::size_t i, Way way,
                           const TrackingLevels& levels) {
    to[i] = PowerOf(setting, plan, way, levels);
  };
  const std::size_t count = std::max(kNoises.size(), kSpreads.size());
  const auto work = [&](int job) {
    const std::size_t i = static_cast<std::size_t>(job) % count;
    const std::size_t curve = static_cast<std::size_t>(job) / count;
    if (curve < 2 && i < kNoises.size()) {
      measure(curve == 0 ? proposed : noise.ratio, i,
              curve == 0 ? Way::kProposed : Way::kSynchronous, {.noise_dq = 1e-3 * kNoises.at(i)});
    }
    if (curve >= 2 && i < kSpreads.size()) {
      measure(curve == 2 ? beat.ratio : one_clock.ratio, i, Way::kSynchronous,
              {.arrival_spread = FromSeconds(1e-6 * kSpreads.at(i)), .has_beat = curve == 2});
    }
  };
  InParallel(setting, 4 * static_cast<int>(count), work, from, 1);
  for (std::size_t i = 0; i < kNoises.size(); ++i) noise.ratio[i] /= proposed[i];
  for (Curve* curve : {&beat, &one_clock}) {
    for (double& ratio : curve->ratio) ratio /= proposed[0];
  }
  double most = 0;
  const double at = NoiseAtPapersRatio(noise, most);
  findings.comparisons.push_back(
      {.quantity = "Noise of dq at which the ratio of joint 1 would be 10, by 1 / noise^2",
       .unit = "mrad/s",
       .ours = at});
  findings.comparisons.push_back(
      {.quantity = "Largest noise of dq tried at which both loops reach the goal",
       .unit = "mrad/s",
       .ours = most});
  findings.comparisons.push_back(
      {.quantity = "Spread of the states' arrival at which the ratio would be 10, no beat",
       .unit = "us",
       .ours = FirstAtPapersRatio(one_clock)});
  findings.comparisons.push_back({.quantity = "The same with the beat, where it jumps",
                                  .unit = "us",
                                  .ours = FirstAtPapersRatio(beat)});
  findings.figures.push_back(LevelsFigure(noise, beat, one_clock));
}

}  // namespace twin::experiment
