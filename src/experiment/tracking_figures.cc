#include "experiment/tracking_figures.h"

#include <string>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "twin/core/time.h"
#include "twin/report/chart.h"

namespace twin::experiment {
namespace {

using report::ChartCurve;
using report::ChartPanel;

constexpr std::string_view kFilteredColour = report::colour::kSeries[3];
/// In the place of a key beside seven small panels.
constexpr const char* kColours =
    "red: synchronous + low-pass; amber: asynchronous; green: asynchronous + low-pass";

struct NamedRun {
  const char* name;
  const char* column;
  std::string_view colour;
  const TrackingCurves& curves;
};

/// The three configurations of the paper, in the order in which they are drawn.
std::array<NamedRun, 3> PaperRuns(const TrackingRuns& runs) {
  return {{{"synchronous + low-pass", "rs", report::colour::kSynchronous, runs.synchronous},
           {"asynchronous + generator", "ra", report::colour::kAsynchronous, runs.proposed},
           {"asynchronous + generator + low-pass", "ra_low_pass", kFilteredColour, runs.filtered}}};
}

ChartCurve VelocityCurve(std::string name, std::string_view colour,
                         const std::vector<double>& values, std::size_t every) {
  ChartCurve curve{.name = std::move(name), .colour = colour};
  for (std::size_t k = 0; k < values.size(); k += every) {
    curve.x.push_back(static_cast<double>(k) * kCycleSeconds);
    curve.y.push_back(values[k]);
  }
  return curve;
}

ChartCurve SpectrumCurve(std::string name, std::string_view colour, const Spectrum& spectrum) {
  ChartCurve curve{.name = std::move(name), .colour = colour};
  for (std::size_t i = 1; i < spectrum.density.size(); ++i) {
    curve.x.push_back(spectrum.frequency_hz(i));
    curve.y.push_back(spectrum.density[i]);
  }
  return curve;
}

ChartPanel VelocityPanel(const TrackingRuns& runs, std::size_t joint, std::size_t every, bool key) {
  ChartPanel panel{
      .title = fmt::format("joint {}", joint + 1), .x_label = "t [s]", .y_label = "dq [rad/s]"};
  for (const NamedRun& run : PaperRuns(runs)) {
    panel.curves.push_back(
        VelocityCurve(key ? run.name : "", run.colour, run.curves.dq[joint], every));
  }
  ChartCurve planned =
      VelocityCurve(key ? "planned" : "", report::colour::kReference, runs.planned[joint], every);
  planned.style = ChartCurve::Style::kDashed;
  panel.curves.push_back(std::move(planned));
  return panel;
}

ChartPanel SpectrumPanel(const TrackingRuns& runs, std::size_t joint, bool key) {
  ChartPanel panel{.title = fmt::format("joint {}", joint + 1),
                   .x_label = "f [Hz]",
                   .y_label = "PSD of dq [(rad/s)^2/Hz]",
                   .log_x = true,
                   .log_y = true};
  for (const NamedRun& run : PaperRuns(runs)) {
    panel.curves.push_back(
        SpectrumCurve(key ? run.name : "", run.colour, run.curves.spectrum[joint]));
  }
  if (runs.quiet.spectrum[joint].density.empty()) return panel;
  ChartCurve quiet = SpectrumCurve(key ? "synchronous, timing faults off" : "",
                                   report::colour::kReference, runs.quiet.spectrum[joint]);
  quiet.style = ChartCurve::Style::kDashed;
  panel.curves.push_back(std::move(quiet));
  return panel;
}

/// A value, or none where a run ended early.
double At(const std::vector<double>& values, std::size_t i) {
  return i < values.size() ? values[i] : 0;
}

}  // namespace

Figure DrawFirstJoint(const TrackingRuns& runs) {
  Figure figure{
      .id = "joint_1",
      .title = "Position control, joint 1: measured velocity and its spectrum",
      .what =
          "The synchronous loop swings about the plan while every second cycle goes unserved, "
          "and carries by far the most power between 20 and 150 Hz; the low-pass behind the "
          "generator is smooth and follows a fraction of the "
          "motion; the generator alone follows and is smooth.",
      .svg = {},
      .columns = "t [s],planned [rad/s],rs [rad/s],ra [rad/s],ra_low_pass [rad/s]",
      .rows = {}};
  report::Chart chart{.title = "Joint 1, 18.32 s, rate limiter on in all",
                      .panels = {VelocityPanel(runs, 0, 1, true), SpectrumPanel(runs, 0, true)}};
  figure.svg = report::DrawChart(chart);
  for (std::size_t k = 0; k < runs.planned[0].size(); ++k) {
    figure.rows.push_back({static_cast<double>(k) * kCycleSeconds, runs.planned[0][k],
                           At(runs.synchronous.dq[0], k), At(runs.proposed.dq[0], k),
                           At(runs.filtered.dq[0], k)});
  }
  return figure;
}

Figure DrawVelocities(const TrackingRuns& runs) {
  constexpr std::size_t kEvery = 10;
  Figure figure{.id = "velocities",
                .title = "Measured velocity of all joints",
                .what =
                    "The other joints behave like the first: only the low-passed generator "
                    "falls short of the planned motion.",
                .svg = {},
                .columns = "t [s]",
                .rows = {}};
  report::Chart chart{.title = kColours, .columns = 2, .panel_height = 220, .panels = {}};
  for (std::size_t j = 0; j < kJoints; ++j) {
    chart.panels.push_back(VelocityPanel(runs, j, kEvery, false));
    figure.columns += fmt::format(",planned_{0} [rad/s]", j + 1);
    for (const NamedRun& run : PaperRuns(runs)) {
      figure.columns += fmt::format(",{}_{} [rad/s]", run.column, j + 1);
    }
  }
  figure.svg = report::DrawChart(chart);
  for (std::size_t k = 0; k < runs.planned[0].size(); k += kEvery) {
    std::vector<double> row{static_cast<double>(k) * kCycleSeconds};
    for (std::size_t j = 0; j < kJoints; ++j) {
      row.push_back(runs.planned[j][k]);
      for (const NamedRun& run : PaperRuns(runs)) row.push_back(At(run.curves.dq[j], k));
    }
    figure.rows.push_back(std::move(row));
  }
  return figure;
}

Figure DrawSpectra(const TrackingRuns& runs) {
  Figure figure{.id = "spectra",
                .title = "Spectrum of the measured velocity of all joints",
                .what =
                    "Between 20 and 150 Hz the synchronous loop stands far above the others "
                    "on every joint; without timing faults (dashes) it lies on the sensors' noise.",
                .svg = {},
                .columns = "f [Hz]",
                .rows = {}};
  report::Chart chart{
      .title = std::string(kColours), .columns = 2, .panel_height = 220, .panels = {}};
  for (std::size_t j = 0; j < kJoints; ++j) {
    chart.panels.push_back(SpectrumPanel(runs, j, false));
    for (const NamedRun& run : PaperRuns(runs)) {
      figure.columns += fmt::format(",{}_{} [rad^2/s^2/Hz]", run.column, j + 1);
    }
    figure.columns += fmt::format(",rs_quiet_{} [rad^2/s^2/Hz]", j + 1);
  }
  figure.svg = report::DrawChart(chart);
  for (std::size_t i = 0; i <= kTrackingSegment / 2; ++i) {
    std::vector<double> row{runs.quiet.spectrum[0].frequency_hz(i)};
    for (std::size_t j = 0; j < kJoints; ++j) {
      for (const NamedRun& run : PaperRuns(runs))
        row.push_back(At(run.curves.spectrum[j].density, i));
      row.push_back(At(runs.quiet.spectrum[j].density, i));
    }
    figure.rows.push_back(std::move(row));
  }
  return figure;
}

}  // namespace twin::experiment
