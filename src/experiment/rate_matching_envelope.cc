#include "experiment/rate_matching_envelope.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "experiment/recording.h"
#include "experiment/runs.h"
#include "twin/core/joint_vector.h"

namespace twin::experiment {
namespace {

constexpr std::size_t kWindow = 250;      // cycles of an envelope's point
constexpr double kMostDifference = 0.05;  // of a joint's largest speed
constexpr const char* kRates = "125 Hz, velocity, canonical trajectory";

/// One run. @returns whether it reached its goal.
bool RunCanonical(const Setting& setting, bool stage, bool limiter, Recording& recording) {
  scenario::Scenario scenario = LoadScenario(setting, "asynchronous");
  scenario.seed = SeedOfRun(setting, 0);
  scenario.motion.interface = control::CommandInterface::kJointVelocity;
  scenario.tick.generator = loop::Generator::kNone;
  scenario.tick.rate_matching = stage;
  scenario.tick.limiter = limiter;
  scenario.tick.finish_tolerance = 1e-2;  // nothing feeds the position back
  scenario.controller.rate_hz = 125;
  // No state comes late: what a lost cycle does to a riser is not the stage's affair.
  scenario.link.state.delay = {rt::ConstantDelay{std::chrono::microseconds(100)}};
  return RunScenario(setting, scenario, &recording).report.succeeded();
}

/// Largest magnitude in each window.
std::vector<double> EnvelopeOf(const std::vector<double>& signal) {
  std::vector<double> envelope;
  for (std::size_t begin = 0; begin < signal.size(); begin += kWindow) {
    double most = 0;
    for (std::size_t k = begin; k < std::min(begin + kWindow, signal.size()); ++k) {
      most = std::max(most, std::abs(signal[k]));
    }
    envelope.push_back(most);
  }
  return envelope;
}

/// Largest difference of two envelopes, as a share of the largest value of the first.
double Difference(const std::vector<double>& a, const std::vector<double>& b) {
  double most = 0;
  double largest = 0;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
    most = std::max(most, std::abs(a[i] - b[i]));
    largest = std::max(largest, a[i]);
  }
  return largest > 0 ? most / largest : 0;
}

std::vector<double> Velocity(const Recording& recording, std::size_t joint) {
  return Signal(recording.cycles(), &CycleSample::dq_d, joint, 0, recording.cycles().size());
}

Figure EnvelopesFigure(const Recording& off, const Recording& on) {
  constexpr std::size_t kEvery = 4;
  Figure figure{.id = "envelopes", .columns = "t [s]"};
  std::vector<std::vector<double>> columns;
  for (std::size_t j = 0; j < kJoints; ++j) {
    columns.push_back(Velocity(off, j));
    columns.push_back(Velocity(on, j));
    figure.columns += fmt::format(",off_{0} [rad/s],on_{0} [rad/s]", j + 1);
  }
  const std::size_t cycles = std::ranges::min(columns, {}, &std::vector<double>::size).size();
  for (std::size_t k = 0; k < cycles; k += kEvery) {
    std::vector<double>& row = figure.rows.emplace_back(1, static_cast<double>(k) * kCycleSeconds);
    for (const std::vector<double>& column : columns) row.push_back(column[k]);
  }
  return figure;
}

}  // namespace

void AddEnvelopes(const Setting& setting, Findings& findings) {
  Recording off;
  Recording on;
  Recording unlimited;
  bool off_well = false;
  bool on_well = false;
  bool unlimited_well = false;
  InParallel(setting, 3, [&](int i) {
    if (i == 0) off_well = RunCanonical(setting, false, true, off);
    if (i == 1) on_well = RunCanonical(setting, true, true, on);
    if (i == 2) unlimited_well = RunCanonical(setting, false, false, unlimited);
  });
  double most = 0;
  for (std::size_t j = 0; j < kJoints; ++j) {
    most = std::max(most, Difference(EnvelopeOf(Velocity(off, j)), EnvelopeOf(Velocity(on, j))));
  }
  findings.comparisons.push_back(
      {.quantity = fmt::format("{}: envelopes off and on apart, the most of any joint", kRates),
       .unit = "%",
       .ours = 100 * most,
       .demand = fmt::format("at most {:g} % of the joint's largest speed, and both reach the goal",
                             100 * kMostDifference),
       .verdict = Judge(off_well && on_well && most <= kMostDifference)});
  findings.comparisons.push_back(
      {.quantity = fmt::format("{}, stage and rate limiter off: aborts", kRates),
       .unit = "%",
       .ours = unlimited_well ? 0.0 : 100.0});
  findings.figures.push_back(EnvelopesFigure(off, on));
}

}  // namespace twin::experiment
