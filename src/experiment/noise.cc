#include <cmath>
#include <limits>
#include <numbers>

#include <fmt/format.h>

#include "experiment/stream.h"
#include "experiment/studies.h"
#include "twin/onboard/violations.h"

namespace twin::experiment {
namespace {

constexpr double kGentle = 0.02;                                // of the acceleration limits
constexpr double kPeakAcceleration = 10 / std::numbers::sqrt3;  // of 1 rad in 1 s, rad/s^2

struct NoiseStage {
  Remedy remedy;
  std::string_view name;
};
constexpr std::array kNoiseStages{
    NoiseStage{Remedy::kNone, "raw"},
    NoiseStage{Remedy::kLimiter, "rate limiter"},
    NoiseStage{Remedy::kLowPass, "low-pass 100 Hz"},
    NoiseStage{Remedy::kRateMatching, "rate matching, source of 125 Hz"},
    NoiseStage{Remedy::kGenerator, "reference generator"},
    NoiseStage{Remedy::kGivenVelocity, "reference generator, velocity given"}};

using NoiseOfStages = std::array<NoiseCurves, kNoiseStages.size()>;

Figure NoiseJointsFigure(const NoiseOfStages& all) {
  Figure figure{.id = "joints", .columns = "stage,amplitude [rad]", .names = NamesOf(kNoiseStages)};
  for (std::size_t j = 1; j <= kJoints; ++j) figure.columns += fmt::format(",joint {} aborted", j);
  for (std::size_t stage = 0; stage < all.size(); ++stage) {
    for (std::size_t i = 0; i < all[stage].amplitude.size(); ++i) {
      std::vector<double>& row = figure.rows.emplace_back(Row(stage, all[stage].amplitude[i]));
      for (const auto& aborted : all[stage].aborted) row.push_back(aborted[i]);
    }
  }
  return figure;
}

Figure NoiseJerkFigure(const NoiseOfStages& all) {
  std::vector<Column> columns{{"amplitude [rad]", all[0].amplitude}};
  for (std::size_t stage = 0; stage < all.size(); ++stage) {
    std::string name(kNoiseStages[stage].name);
    std::ranges::replace(name, ',', ' ');
    columns.push_back({std::move(name), all[stage].rms_jerk[0]});
  }
  return FigureOf("jerk", columns);
}

void CompareNoise(const NoiseOfStages& all, Findings& findings) {
  const NoiseCurves& raw = all[0];
  for (std::size_t j = 0; j < kJoints; ++j) {
    const double half = HalfAborted(raw, j);
    findings
        .Add(fmt::format("joint {}: amplitude that aborts half of the raw runs", j + 1), "rad",
             half)
        .Paper(1e-6)
        .Demand("of the paper's order of magnitude: within a factor of 3.2",
                half >= 1e-6 / std::sqrt(10.0) && half <= 1e-6 * std::sqrt(10.0));
  }
  for (std::size_t stage = 1; stage < all.size(); ++stage) {
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t j = 0; j < kJoints; ++j) {
      least = std::min(least, HalfAborted(all[stage], j) / HalfAborted(raw, j));
    }
    // Without an abort within the amplitudes tried, the largest of them is a lower bound.
    const double largest = all[stage].amplitude.back() / HalfAborted(raw, 0);
    const bool bounded = std::isfinite(least);
    findings.Add(fmt::format("{}: admissible amplitude / raw, worst joint{}",
                             kNoiseStages[stage].name, bounded ? "" : " (no abort: a lower bound)"),
                 "", bounded ? least : largest);
  }
}

}  // namespace

NoiseCurves MeasureNoise(const Config& config, const scenario::RobotData& robot, Remedy remedy,
                         const std::vector<double>& amplitude, int runs) {
  JointVector displacement;
  for (std::size_t j = 0; j < kJoints; ++j) {
    displacement[j] = kGentle * robot.limits.ddq_max[j] / kPeakAcceleration;
  }
  const reference::Trajectory plan = SecondOfMotion(displacement, robot.limits);
  NoiseCurves curves{.amplitude = amplitude, .aborted = {}, .rms_jerk = {}};
  curves.aborted.fill(std::vector<double>(amplitude.size()));
  curves.rms_jerk = curves.aborted;
  const auto job = [&](int i) {
    Stream stream = StreamBehind(remedy, robot);
    stream.noise = amplitude[i];
    for (int run = 0; run < runs; ++run) {
      stream.seed = SeedOfRun(config, i * runs + run);
      const StreamResult result = RunStream(plan, robot.limits, stream, false);
      for (std::size_t j = 0; j < kJoints; ++j) {
        curves.aborted[j][i] += result.share[j] > 1 + onboard::kLimitTolerance ? 1.0 / runs : 0;
        curves.rms_jerk[j][i] += result.rms_jerk[j] / runs;
      }
    }
  };
  InParallel(config, static_cast<int>(amplitude.size()), job);
  return curves;
}

double HalfAborted(const NoiseCurves& curves, std::size_t joint) {
  const std::vector<double>& aborted = curves.aborted[joint];
  for (std::size_t i = 0; i < aborted.size(); ++i) {
    if (aborted[i] < 0.5) continue;
    if (i == 0) return curves.amplitude[0];
    const double share = (0.5 - aborted[i - 1]) / (aborted[i] - aborted[i - 1]);
    return curves.amplitude[i - 1] * std::pow(curves.amplitude[i] / curves.amplitude[i - 1], share);
  }
  return std::numeric_limits<double>::infinity();
}

Findings RunNoise(const Config& config) {
  const StreamInputs inputs = LoadStreamInputs(config);
  const double each = 1.0 / kNoiseStages.size();
  NoiseOfStages all;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const double begin = each * static_cast<double>(i);
    all[i] = MeasureNoise(PartOf(config, begin, begin + each), inputs.robot, kNoiseStages[i].remedy,
                          LogEdges(1e-7, 1e-2, 10), config.seeds);
  }
  Findings findings{.values = {{"acceleration", fmt::format("{:.0f}", kGentle * 100)},
                               {"runs", fmt::format("{}", config.seeds)}}};
  CompareNoise(all, findings);
  findings.figures = {NoiseJointsFigure(all), NoiseJerkFigure(all)};
  return findings;
}

}  // namespace twin::experiment
