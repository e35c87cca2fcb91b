#include "experiment/tracking_response.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>
#include <vector>

#include "experiment/recording.h"
#include "experiment/runs.h"
#include "experiment/spectrum.h"
#include "twin/reference/low_pass.h"

namespace twin::experiment {
namespace {

constexpr std::array<double, kJoints> kFrequencies{0.05, 0.1, 0.2, 0.5, 1, 2, 5};
constexpr JointVector kMiddle{0, -0.5, 0, -2, 0, 1.6, 0.7};
/// At most 0.5 rad/s and 1 rad/s^2: gentle enough for the reference generator's promise.
constexpr JointVector kAmplitudes{0.5, 0.5, 0.3, 0.1, 0.025, 0.006, 0.001};
constexpr double kLengthS = 40;
constexpr double kRampS = 3;
/// What is compared: whole periods of all sines, after 17 s, six of the longest time constant.
constexpr double kFromS = 17;
constexpr double kToS = 37;

/// 0 to 1, at rest at both ends.
double SmoothStep(double x) {
  const double c = std::clamp(x, 0.0, 1.0);
  return c * c * c * (10 + c * (-15 + 6 * c));
}

std::vector<reference::Waypoint> Swings() {
  constexpr int kStepMs = 10;
  std::vector<reference::Waypoint> waypoints;
  for (int ms = 0; ms <= static_cast<int>(kLengthS * 1000); ms += kStepMs) {
    const double t = ms * 1e-3;
    const double share = SmoothStep(t / kRampS) * SmoothStep((kLengthS - t) / kRampS);
    reference::Waypoint point{.q = kMiddle, .at = std::chrono::milliseconds(ms)};
    for (std::size_t j = 0; j < kJoints; ++j) {
      point.q[j] += kAmplitudes[j] * share * std::sin(2 * std::numbers::pi * kFrequencies[j] * t);
    }
    waypoints.push_back(point);
  }
  return waypoints;
}

/// Velocity that was in use when each cycle's command was made; held where none was.
std::vector<JointVector> VelocitiesInUse(const Recording& recording) {
  std::vector<JointVector> values;
  std::size_t next = 0;
  JointVector newest{};
  for (const CycleSample& cycle : recording.cycles()) {
    while (next < recording.ticks().size() &&
           recording.ticks()[next].message_id < cycle.message_id) {
      newest = recording.ticks()[next++].dq_ext;
    }
    values.push_back(newest);
  }
  return values;
}

}  // namespace

double FollowedShare::largest_error() const noexcept {
  double largest = 0;
  for (std::size_t j = 0; j < kJoints; ++j) {
    largest = std::max(largest, std::abs(measured[j] - expected[j]) / std::abs(expected[j]));
  }
  return largest;
}

std::complex<double> LowPassedResponse(double gain, double lambda, double frequency_hz) noexcept {
  const std::complex<double> s{0, 2 * std::numbers::pi * frequency_hz};
  const double rate = lambda / kCycleSeconds;
  return gain * (s + rate) / (s + gain * rate);
}

FollowedShare MeasureFollowedShare(const Setting& setting, double low_pass_hz) {
  scenario::Scenario scenario = LoadScenario(setting, "asynchronous");
  scenario.seed = SeedOfRun(setting, 0);
  scenario.tick.low_pass_hz = low_pass_hz;
  scenario.tick.finish_tolerance = 1e-2;
  scenario.motion.waypoints = Swings();
  scenario.motion.timing = {};
  Recording recording;
  RunScenario(setting, scenario, &recording);
  const std::vector<JointVector> in_use = VelocitiesInUse(recording);
  FollowedShare share{.frequency_hz = kFrequencies};
  const auto cycle = [](double seconds) {
    return static_cast<std::size_t>(seconds / kCycleSeconds);
  };
  const double gain = reference::LowPass(low_pass_hz).gain();
  for (std::size_t j = 0; j < kJoints; ++j) {
    share.expected[j] = LowPassedResponse(gain, scenario.tick.lambda, kFrequencies[j]);
    if (in_use.size() < cycle(kToS)) continue;  // it ended early: nothing was followed
    std::vector<double> deposited;
    for (std::size_t k = cycle(kFromS); k < cycle(kToS); ++k) deposited.push_back(in_use[k][j]);
    const std::vector<double> followed =
        Signal(recording.cycles(), &CycleSample::dq_d, j, cycle(kFromS), cycle(kToS));
    const double rate = 1 / kCycleSeconds;
    share.measured[j] = SineAmplitude(followed, rate, kFrequencies[j]) /
                        SineAmplitude(deposited, rate, kFrequencies[j]);
  }
  return share;
}

Figure FollowedShareFigure(const FollowedShare& share, double gain, double lambda) {
  Figure figure{.id = "low_pass_response",
                .columns = "f [Hz],share,share by formula,phase [rad],phase by formula [rad]",
                .values = {{"gain", gain}, {"lambda", lambda}}};
  for (std::size_t j = 0; j < kJoints; ++j) {
    figure.rows.push_back({share.frequency_hz[j], std::abs(share.measured[j]),
                           std::abs(share.expected[j]), std::arg(share.measured[j]),
                           std::arg(share.expected[j])});
  }
  return figure;
}

}  // namespace twin::experiment
