#include "experiment/tracking_figures.h"

#include <array>
#include <vector>

#include <fmt/format.h>

#include "twin/core/time.h"

namespace twin::experiment {
namespace {

struct NamedRun {
  const char* column;
  const TrackingCurves& curves;
};

/// The three configurations of the paper, in the order in which they are drawn.
std::array<NamedRun, 3> PaperRuns(const TrackingRuns& runs) {
  return {{{"rs", runs.synchronous}, {"ra", runs.proposed}, {"ra_low_pass", runs.filtered}}};
}

/// A value, or none where a run ended early.
double At(const std::vector<double>& values, std::size_t i) {
  return i < values.size() ? values[i] : 0;
}

}  // namespace

Figure FirstJointFigure(const TrackingRuns& runs) {
  Figure figure{.id = "joint_1",
                .columns = "t [s],planned [rad/s],rs [rad/s],ra [rad/s],ra_low_pass [rad/s]",
                .tables = {{"spectrum", {.columns = "f [Hz],rs,ra,ra_low_pass,rs_quiet"}}}};
  for (std::size_t k = 0; k < runs.planned[0].size(); ++k) {
    figure.rows.push_back({static_cast<double>(k) * kCycleSeconds, runs.planned[0][k],
                           At(runs.synchronous.dq[0], k), At(runs.proposed.dq[0], k),
                           At(runs.filtered.dq[0], k)});
  }
  const Spectrum& frequencies = runs.proposed.spectrum[0];
  for (std::size_t i = 1; i < frequencies.density.size(); ++i) {
    std::vector<double>& row =
        figure.tables["spectrum"].rows.emplace_back(1, frequencies.frequency_hz(i));
    for (const NamedRun& run : PaperRuns(runs))
      row.push_back(At(run.curves.spectrum[0].density, i));
    row.push_back(At(runs.quiet.spectrum[0].density, i));
  }
  return figure;
}

Figure VelocitiesFigure(const TrackingRuns& runs) {
  constexpr std::size_t kEvery = 10;
  Figure figure{.id = "velocities", .columns = "t [s]"};
  for (std::size_t j = 1; j <= kJoints; ++j) {
    figure.columns += fmt::format(",planned_{0} [rad/s]", j);
    for (const NamedRun& run : PaperRuns(runs)) {
      figure.columns += fmt::format(",{}_{} [rad/s]", run.column, j);
    }
  }
  for (std::size_t k = 0; k < runs.planned[0].size(); k += kEvery) {
    std::vector<double>& row = figure.rows.emplace_back(1, static_cast<double>(k) * kCycleSeconds);
    for (std::size_t j = 0; j < kJoints; ++j) {
      row.push_back(runs.planned[j][k]);
      for (const NamedRun& run : PaperRuns(runs)) row.push_back(At(run.curves.dq[j], k));
    }
  }
  return figure;
}

Figure SpectraFigure(const TrackingRuns& runs) {
  Figure figure{.id = "spectra", .columns = "f [Hz]"};
  for (std::size_t j = 1; j <= kJoints; ++j) {
    for (const NamedRun& run : PaperRuns(runs)) {
      figure.columns += fmt::format(",{}_{} [rad^2/s^2/Hz]", run.column, j);
    }
    figure.columns += fmt::format(",rs_quiet_{} [rad^2/s^2/Hz]", j);
  }
  for (std::size_t i = 0; i <= kTrackingSegment / 2; ++i) {
    std::vector<double>& row = figure.rows.emplace_back(1, runs.quiet.spectrum[0].frequency_hz(i));
    for (std::size_t j = 0; j < kJoints; ++j) {
      for (const NamedRun& run : PaperRuns(runs))
        row.push_back(At(run.curves.spectrum[j].density, i));
      row.push_back(At(runs.quiet.spectrum[j].density, i));
    }
  }
  return figure;
}

}  // namespace twin::experiment
