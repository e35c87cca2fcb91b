#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "experiment/runs.h"
#include "experiment/tracking.h"
#include "twin/core/error.h"

namespace twin::experiment {
namespace {

/// Columns by Setup; the last is shown among the spectra only.
constexpr std::array<std::string_view, kSetups> kColumns{"rs", "ra", "ra_low_pass", "rs_quiet"};
constexpr std::size_t kPaperSetups = 3;

/// A value, or 0 where a run ended early.
double At(const std::vector<double>& values, std::size_t i) {
  return i < values.size() ? values[i] : 0;
}

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kPaperRatio = 10;

/// Ratios at the levels tried; NaN where a run did not reach its goal.
struct LevelCurve {
  std::vector<double> x;
  std::vector<double> ratio;
};

/// Power of joint 1 in the band; NaN when the robot ended the motion.
double PowerOf(const Config& config, const reference::Trajectory& plan, Setup setup,
               const TrackingLevels& levels) {
  try {
    const TrackingOutcome outcome = MeasureTracking(config, plan, setup, 0, levels);
    return outcome.succeeded ? outcome.band[0] : kNaN;
  } catch (const RobotFault&) {
    ThrowIfInterrupted(config);
    return kNaN;
  }
}

/// The level at which the ratio first is the paper's, interpolated by both logarithms.
double FirstAtPapersRatio(const LevelCurve& curve) {
  for (std::size_t i = 1; i < curve.x.size(); ++i) {
    const double a = curve.ratio[i - 1];
    const double b = curve.ratio[i];
    if (!(std::min(a, b) < kPaperRatio && std::max(a, b) >= kPaperRatio)) continue;
    const double share = std::log(kPaperRatio / a) / std::log(b / a);
    return curve.x[i - 1] * std::pow(curve.x[i] / curve.x[i - 1], share);
  }
  return kNaN;
}

/// The same of noise, which both loops have: ratio - 1 goes with 1 / noise^2. From the last level
/// at which both reached their goal.
double NoiseAtPapersRatio(const LevelCurve& noise, double& last) {
  double at = kNaN;
  for (std::size_t i = 0; i < noise.x.size(); ++i) {
    if (!std::isfinite(noise.ratio[i])) break;
    last = noise.x[i];
    at = last * std::sqrt((noise.ratio[i] - 1) / (kPaperRatio - 1));
  }
  return at;
}

}  // namespace

Figure FirstJointFigure(const TrackingRuns& runs) {
  Figure figure{.id = "joint_1",
                .columns = "t [s],planned [rad/s],rs [rad/s],ra [rad/s],ra_low_pass [rad/s]",
                .tables = {{"spectrum", {.columns = "f [Hz],rs,ra,ra_low_pass,rs_quiet"}}}};
  for (std::size_t k = 0; k < runs.planned[0].size(); ++k) {
    std::vector<double>& row = figure.rows.emplace_back(
        std::vector{static_cast<double>(k) * kCycleSeconds, runs.planned[0][k]});
    for (std::size_t s = 0; s < kPaperSetups; ++s) row.push_back(At(runs.curves[s].dq[0], k));
  }
  const Spectrum& frequencies = runs.curves[static_cast<std::size_t>(Setup::kProposed)].spectrum[0];
  for (std::size_t i = 1; i < frequencies.density.size(); ++i) {
    std::vector<double>& row =
        figure.tables["spectrum"].rows.emplace_back(1, frequencies.frequency_hz(i));
    for (const TrackingCurves& run : runs.curves) row.push_back(At(run.spectrum[0].density, i));
  }
  return figure;
}

Figure VelocitiesFigure(const TrackingRuns& runs) {
  constexpr std::size_t kEvery = 10;
  Figure figure{.id = "velocities", .columns = "t [s]"};
  for (std::size_t j = 1; j <= kJoints; ++j) {
    figure.columns += fmt::format(",planned_{0} [rad/s]", j);
    for (std::size_t s = 0; s < kPaperSetups; ++s) {
      figure.columns += fmt::format(",{}_{} [rad/s]", kColumns[s], j);
    }
  }
  for (std::size_t k = 0; k < runs.planned[0].size(); k += kEvery) {
    std::vector<double>& row = figure.rows.emplace_back(1, static_cast<double>(k) * kCycleSeconds);
    for (std::size_t j = 0; j < kJoints; ++j) {
      row.push_back(runs.planned[j][k]);
      for (std::size_t s = 0; s < kPaperSetups; ++s) row.push_back(At(runs.curves[s].dq[j], k));
    }
  }
  return figure;
}

Figure SpectraFigure(const TrackingRuns& runs) {
  Figure figure{.id = "spectra", .columns = "f [Hz]"};
  for (std::size_t j = 1; j <= kJoints; ++j) {
    for (const std::string_view column : kColumns) {
      figure.columns += fmt::format(",{}_{} [rad^2/s^2/Hz]", column, j);
    }
  }
  const Spectrum& frequencies = runs.curves[static_cast<std::size_t>(Setup::kQuiet)].spectrum[0];
  for (std::size_t i = 0; i <= kTrackingSegment / 2; ++i) {
    std::vector<double>& row = figure.rows.emplace_back(1, frequencies.frequency_hz(i));
    for (std::size_t j = 0; j < kJoints; ++j) {
      for (const TrackingCurves& run : runs.curves) row.push_back(At(run.spectrum[j].density, i));
    }
  }
  return figure;
}

void AddLevels(const Config& config, const reference::Trajectory& plan, double from,
               Findings& findings) {
  const std::vector<double> noises{1, 4, 8, 12};            // mrad/s
  const std::vector<double> spreads{0.3, 1, 3, 6, 10, 30};  // us
  struct Run {
    Setup setup;
    TrackingLevels levels;
  };
  std::vector<Run> runs;
  for (const Setup setup : {Setup::kProposed, Setup::kSynchronous}) {
    for (const double noise : noises) runs.push_back({setup, {.noise_dq = 1e-3 * noise}});
  }
  for (const bool has_beat : {true, false}) {
    for (const double spread : spreads) {
      runs.push_back({Setup::kSynchronous,
                      {.arrival_spread = FromSeconds(1e-6 * spread), .has_beat = has_beat}});
    }
  }
  const std::vector<double> powers = MapInParallel(
      config, runs.size(),
      [&](int i) { return PowerOf(config, plan, runs[i].setup, runs[i].levels); }, from, 1);
  const auto proposed = powers.begin();
  auto next = proposed + static_cast<std::ptrdiff_t>(noises.size());
  LevelCurve noise{noises, {}};
  for (std::size_t i = 0; i < noises.size(); ++i) noise.ratio.push_back(*next++ / proposed[i]);
  LevelCurve beat{spreads, {}};
  LevelCurve one_clock = beat;
  for (LevelCurve* curve : {&beat, &one_clock}) {
    for (std::size_t i = 0; i < spreads.size(); ++i) curve->ratio.push_back(*next++ / proposed[0]);
  }
  double most = 0;
  const double at = NoiseAtPapersRatio(noise, most);
  findings.Add("Noise of dq at which the ratio of joint 1 would be 10, by 1 / noise^2", "mrad/s",
               at);
  findings.Add("Largest noise of dq tried at which both loops reach the goal", "mrad/s", most);
  findings.Add("Spread of the states' arrival at which the ratio would be 10, no beat", "us",
               FirstAtPapersRatio(one_clock));
  findings.Add("The same with the beat, where it jumps", "us", FirstAtPapersRatio(beat));
  Figure figure{.id = "levels",
                .columns =
                    "varied: 0 noise [mrad/s]; 1 spread with a beat [us]; 2 spread without "
                    "[us],value,ratio"};
  double kind = 0;
  for (const LevelCurve* curve : {&noise, &beat, &one_clock}) {
    for (std::size_t i = 0; i < curve->x.size(); ++i) {
      figure.rows.push_back({kind, curve->x[i], curve->ratio[i]});
    }
    ++kind;
  }
  findings.figures.push_back(std::move(figure));
}

}  // namespace twin::experiment
