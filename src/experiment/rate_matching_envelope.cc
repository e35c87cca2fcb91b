#include "experiment/rate_matching_envelope.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "experiment/recording.h"
#include "experiment/runs.h"
#include "twin/core/joint_vector.h"
#include "twin/report/chart.h"

namespace twin::experiment {
namespace {

using report::ChartCurve;

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

Figure Draw(const Recording& off, const Recording& on) {
  Figure figure{.id = "envelopes",
                .title = "The whole canonical trajectory, rate matching off and on",
                .what =
                    "The two lie on each other over the motion: the stage takes the risers away, "
                    "and nothing of the velocity.",
                .svg = {},
                .columns = "t [s]"};
  constexpr std::size_t kEvery = 4;
  report::Chart chart{.title = "dq_d from a source at 125 Hz; red: off, blue: on",
                      .columns = 2,
                      .panel_height = 200,
                      .panels = {}};
  std::vector<std::vector<double>> columns;
  for (std::size_t j = 0; j < kJoints; ++j) {
    report::ChartPanel panel{
        .title = fmt::format("joint {}", j + 1), .x_label = "t [s]", .y_label = "dq_d [rad/s]"};
    for (const auto& [recording, colour, name] :
         {std::tuple{&off, report::colour::kSynchronous, "off"},
          std::tuple{&on, report::colour::kBare, "on"}}) {
      const std::vector<double> values = Velocity(*recording, j);
      ChartCurve curve{.name = {}, .colour = colour};
      columns.emplace_back();
      for (std::size_t k = 0; k < values.size(); k += kEvery) {
        curve.x.push_back(static_cast<double>(k) * kCycleSeconds);
        curve.y.push_back(values[k]);
        columns.back().push_back(values[k]);
      }
      panel.curves.push_back(std::move(curve));
      figure.columns += fmt::format(",{}_{} [rad/s]", name, j + 1);
    }
    chart.panels.push_back(std::move(panel));
  }
  const std::size_t rows = std::ranges::min(columns, {}, &std::vector<double>::size).size();
  for (std::size_t i = 0; i < rows; ++i) {
    figure.rows.push_back({static_cast<double>(kEvery * i) * kCycleSeconds});
    for (const std::vector<double>& column : columns) figure.rows.back().push_back(column[i]);
  }
  figure.svg = report::DrawChart(chart);
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
  findings.figures.push_back(Draw(off, on));
}

}  // namespace twin::experiment
