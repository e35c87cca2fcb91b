#include "experiment/noise.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "experiment/runs.h"
#include "twin/onboard/violations.h"

namespace twin::experiment {
namespace {

constexpr double kGentle = 0.02;                                // of the acceleration limits
constexpr double kPeakAcceleration = 10 / std::numbers::sqrt3;  // of 1 rad in 1 s, rad/s^2

std::vector<double> Amplitudes() {
  constexpr int kPerDecade = 10;
  std::vector<double> amplitudes;
  for (int i = 0; i <= 5 * kPerDecade; ++i) {
    amplitudes.push_back(1e-7 * std::pow(10, static_cast<double>(i) / kPerDecade));
  }
  return amplitudes;
}

using AllCurves = std::array<NoiseCurves, kNoiseStages.size()>;

Figure JointsFigure(const AllCurves& all) {
  Figure figure{.id = "joints",
                .columns = "stage,amplitude [rad]",
                .names = {kNoiseStages.begin(), kNoiseStages.end()}};
  for (std::size_t j = 1; j <= kJoints; ++j) figure.columns += fmt::format(",joint {} aborted", j);
  for (std::size_t stage = 0; stage < all.size(); ++stage) {
    const NoiseCurves& curves = all[stage];
    for (std::size_t i = 0; i < curves.amplitude.size(); ++i) {
      std::vector<double>& row =
          figure.rows.emplace_back(std::vector{static_cast<double>(stage), curves.amplitude[i]});
      for (const auto& aborted : curves.aborted) row.push_back(aborted[i]);
    }
  }
  return figure;
}

Figure JerkFigure(const AllCurves& all) {
  Figure figure{.id = "jerk", .columns = "amplitude [rad]"};
  for (const std::string_view name : kNoiseStages) {
    std::string stage(name);
    std::ranges::replace(stage, ',', ' ');
    figure.columns += "," + stage;
  }
  for (std::size_t i = 0; i < all[0].amplitude.size(); ++i) {
    std::vector<double>& row = figure.rows.emplace_back(1, all[0].amplitude[i]);
    for (const NoiseCurves& curves : all) row.push_back(curves.rms_jerk[0][i]);
  }
  return figure;
}

void Compare(const AllCurves& all, Findings& findings) {
  const NoiseCurves& raw = all[static_cast<std::size_t>(NoiseStage::kRaw)];
  for (std::size_t j = 0; j < kJoints; ++j) {
    const double half = HalfAborted(raw, j);
    const bool met = half >= 1e-6 / std::sqrt(10.0) && half <= 1e-6 * std::sqrt(10.0);
    findings.comparisons.push_back(
        {.quantity = fmt::format("joint {}: amplitude that aborts half of the raw runs", j + 1),
         .unit = "rad",
         .paper = 1e-6,
         .ours = half,
         .demand = "of the paper's order of magnitude: within a factor of 3.2",
         .verdict = Judge(met)});
  }
  for (std::size_t stage = 1; stage < all.size(); ++stage) {
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t j = 0; j < kJoints; ++j) {
      least = std::min(least, HalfAborted(all[stage], j) / HalfAborted(raw, j));
    }
    // What is not reached within the amplitudes tried is at least the largest of them.
    const double largest = all[stage].amplitude.back() / HalfAborted(raw, 0);
    const bool bounded = std::isfinite(least);
    findings.comparisons.push_back(
        {.quantity = fmt::format("{}: admissible amplitude / raw, worst joint{}",
                                 kNoiseStages[stage], bounded ? "" : " (no abort: a lower bound)"),
         .ours = bounded ? least : largest});
  }
}

}  // namespace

Stream StreamThrough(NoiseStage stage, const scenario::RobotData& robot) {
  Stream stream;
  switch (stage) {
    case NoiseStage::kRaw: break;
    case NoiseStage::kLimiter: stream.tick = WithLimiter(stream.tick, robot); break;
    case NoiseStage::kLowPass: stream.tick.low_pass_hz = 100; break;
    case NoiseStage::kRateMatching: stream.tick.source_rate_hz = 125; break;
    case NoiseStage::kGivenVelocity: stream.velocity = VelocityFrom::kGiven; [[fallthrough]];
    case NoiseStage::kGenerator: stream.tick.generator = loop::Generator::kJoint; break;
  }
  return stream;
}

NoiseCurves MeasureNoise(const Setting& setting, const scenario::RobotData& robot, NoiseStage stage,
                         const std::vector<double>& amplitude, int runs) {
  JointVector displacement;
  for (std::size_t j = 0; j < kJoints; ++j) {
    displacement[j] = kGentle * robot.limits.ddq_max[j] / kPeakAcceleration;
  }
  const reference::Trajectory plan = SecondOfMotion(displacement, robot.limits);
  NoiseCurves curves{.amplitude = amplitude, .runs = runs, .aborted = {}, .rms_jerk = {}};
  for (std::size_t j = 0; j < kJoints; ++j) {
    curves.aborted[j].resize(amplitude.size());
    curves.rms_jerk[j].resize(amplitude.size());
  }
  const double each = 1.0 / kNoiseStages.size();
  const double begin = each * static_cast<double>(stage);
  const auto job = [&](int index) {
    const auto i = static_cast<std::size_t>(index);
    Stream stream = StreamThrough(stage, robot);
    stream.noise = amplitude[i];
    for (int run = 0; run < runs; ++run) {
      stream.seed = SeedOfRun(setting, index * runs + run);
      const StreamResult result = RunStream(plan, robot.limits, stream, false);
      for (std::size_t j = 0; j < kJoints; ++j) {
        curves.aborted[j][i] += result.share[j] > 1 + onboard::kLimitTolerance ? 1.0 / runs : 0;
        curves.rms_jerk[j][i] += result.rms_jerk[j] / runs;
      }
    }
  };
  InParallel(setting, static_cast<int>(amplitude.size()), job, begin, begin + each);
  return curves;
}

double HalfAborted(const NoiseCurves& curves, std::size_t joint) {
  const std::vector<double>& aborted = curves.aborted[joint];
  for (std::size_t i = 0; i < aborted.size(); ++i) {
    if (aborted[i] < 0.5) continue;
    if (i == 0) return curves.amplitude[0];
    const double way = (0.5 - aborted[i - 1]) / (aborted[i] - aborted[i - 1]);
    return curves.amplitude[i - 1] * std::pow(curves.amplitude[i] / curves.amplitude[i - 1], way);
  }
  return std::numeric_limits<double>::infinity();
}

Findings RunNoise(const Setting& setting) {
  const StreamSetting streams = LoadStreamSetting(setting);
  AllCurves all;
  for (std::size_t stage = 0; stage < all.size(); ++stage) {
    all[stage] = MeasureNoise(setting, streams.robot, static_cast<NoiseStage>(stage), Amplitudes(),
                              setting.seeds);
  }
  Findings findings{.values = {{"acceleration", fmt::format("{:.0f}", kGentle * 100)},
                               {"runs", fmt::format("{}", setting.seeds)}}};
  Compare(all, findings);
  findings.figures = {JointsFigure(all), JerkFigure(all)};
  return findings;
}

}  // namespace twin::experiment
