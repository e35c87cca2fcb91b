#include "report/run_plots.h"

#include <algorithm>
#include <limits>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "report/gnuplot.h"
#include "report/script.h"
#include "twin/core/error.h"
#include "twin/core/time.h"
#include "twin/report/plots.h"

namespace twin::report {
namespace {

constexpr const char* kTableColumns = "joint,t [s],value";
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// Common part of all figures of a run.
Figure FigureOf(const RunData& run, std::string id, std::string_view what) {
  Figure figure{.id = std::move(id),
                .values = {{"begin", run.begin},
                           {"end", std::max(run.end, run.begin + 1e-3)},
                           {"aborted", run.abort ? 1 : 0},
                           {"abort", run.abort ? run.abort->time : 0},
                           {"motions", run.motions.size() < 2 ? 0.0 : 1.0 * run.motions.size()}},
                .names = {Title(run, what)}};
  for (std::size_t i = 0; i < run.motions.size(); ++i) {
    figure.values[fmt::format("motion_{}", i + 1)] = run.motions[i];
  }
  return figure;
}

/// The curves of an envelope as a table.
Table TableOf(const Envelope& envelope, std::size_t curves = kJoints) {
  Table table{.columns = kTableColumns};
  for (std::size_t i = 0; i < curves; ++i) {
    for (const Sample& sample : envelope.Curve(i)) {
      table.rows.push_back({static_cast<double>(i + 1), sample.time, sample.value});
    }
  }
  return table;
}

/// The joints' curves of one quantity, and its name in the legend.
struct Curve {
  const Envelope* envelope = nullptr;
  std::string name{};
};

/// A panel for each joint. @param measured  may be empty.
Figure JointPanels(const RunData& run, std::string id, std::string_view what, std::string unit,
                   const Curve& reference, const Curve& measured, bool has_limits) {
  Figure figure = FigureOf(run, std::move(id), what);
  figure.plot = "joint_panels";
  figure.values["limits"] = has_limits ? 1 : 0;
  figure.values["measured"] = measured.envelope != nullptr ? 1 : 0;
  figure.names.insert(figure.names.end(), {std::move(unit), reference.name, measured.name});
  figure.tables["reference"] = TableOf(*reference.envelope);
  figure.tables["measured"] =
      measured.envelope != nullptr ? TableOf(*measured.envelope) : Table{.columns = kTableColumns};
  return figure;
}

/// Adds the panel of the next joint. @param limits  lines, not finite: none. @param range  of y.
void AddPanel(Figure& figure, std::string title, std::pair<double, double> limits,
              std::pair<double, double> range) {
  figure.names.push_back(std::move(title));
  const std::size_t joint = figure.names.size() - 4;
  figure.values[fmt::format("limit_min_{}", joint)] = limits.first;
  figure.values[fmt::format("limit_max_{}", joint)] = limits.second;
  figure.values[fmt::format("y_min_{}", joint)] = range.first;
  figure.values[fmt::format("y_max_{}", joint)] = range.second;
}

/// Range around 0.
std::pair<double, double> PlusMinus(double value) {
  return {-value, value};
}

/// Range that contains a peak, with a margin; +- 1 without a peak.
std::pair<double, double> RangeTo(double peak) {
  return PlusMinus(peak > 0 ? 1.15 * peak : 1);
}

std::string PeakOf(std::size_t joint, double peak, double limit, std::string_view unit) {
  return fmt::format("joint {}: peak {:.3g} of {:.5g} {} ({:.3g} %)", joint + 1, peak, limit, unit,
                     100 * peak / limit);
}

void WriteFigure(const Figure& figure, const std::filesystem::path& path) {
  WriteSvg(DrawPlot("run/", figure), path);
}

}  // namespace

Figure JointsFigure(const RunData& run, const JointLimits& limits) {
  const Curve reference =
      run.by_torque ? Curve{&run.q_ext, "q_ext, target"} : Curve{&run.q_d, "q_d, desired"};
  Figure figure = JointPanels(run, "joints", "joint positions", "rad", reference,
                              {&run.q, "q, measured"}, true);
  for (std::size_t i = 0; i < kJoints; ++i) {
    const double margin = 0.06 * (limits.q_max[i] - limits.q_min[i]);
    AddPanel(figure, fmt::format("joint {}", i + 1), {limits.q_min[i], limits.q_max[i]},
             {limits.q_min[i] - margin, limits.q_max[i] + margin});
  }
  return figure;
}

Figure VelocitiesFigure(const RunData& run, const JointLimits& limits) {
  const Curve reference = run.by_torque ? Curve{&run.dq_ext, "dq_ext, of the target"}
                                        : Curve{&run.dq_d, "dq_d, desired"};
  const JointVector& peaks = run.by_torque ? run.peak_dq : run.peak_dq_d;
  Figure figure = JointPanels(run, "velocities", "joint velocities", "rad/s", reference,
                              {&run.dq, "dq, measured"}, true);
  for (std::size_t i = 0; i < kJoints; ++i) {
    const double limit = limits.dq_max[i];
    AddPanel(figure, PeakOf(i, peaks[i], limit, "rad/s"), PlusMinus(limit),
             PlusMinus(1.1 * std::max(limit, peaks[i])));
  }
  return figure;
}

Figure TrackingFigure(const RunData& run) {
  // Under torques the robot follows no reference, and the two are one.
  const bool has_both = !run.by_torque && !run.deviation.Curve(0).empty();
  const Curve deviation{&run.deviation, "plan minus measured, q_ext - q"};
  const Curve error{&run.error,
                    run.by_torque ? deviation.name : "reference minus measured, q_d - q"};
  Figure figure = JointPanels(run, "tracking", "tracking error and deviation from the plan", "mrad",
                              error, has_both ? deviation : Curve(), false);
  for (std::size_t i = 0; i < kJoints; ++i) {
    std::string peak = run.error.Curve(i).empty()
                           ? "nothing to compare"
                           : fmt::format("peak {:.3g} mrad", run.peak_error[i]);
    if (has_both) peak += fmt::format("; from the plan {:.3g} mrad", run.peak_deviation[i]);
    AddPanel(figure, fmt::format("joint {}: {}", i + 1, peak), {kNone, kNone},
             RangeTo(std::max(run.peak_error[i], has_both ? run.peak_deviation[i] : 0)));
  }
  return figure;
}

Figure TorquesFigure(const RunData& run, const JointLimits& limits) {
  Figure figure =
      JointPanels(run, "torques", "torques", "Nm", {&run.tau_J_d, "tau_J_d, without gravity"},
                  {&run.tau_J, "tau_J, measured, with gravity"}, false);
  for (std::size_t i = 0; i < kJoints; ++i) {
    AddPanel(figure, PeakOf(i, run.peak_tau[i], limits.tau_max[i], "Nm"),
             PlusMinus(limits.tau_max[i]), RangeTo(run.peak_tau[i]));
  }
  return figure;
}

Figure JerkFigure(const RunData& run, const JointLimits& limits) {
  // Below this share of the limit, the curve would coincide with the axis.
  constexpr double kZoomBelow = 0.1;
  const auto zooms = [&](std::size_t i) {
    return run.peak_dddq_d[i] > 0 && run.peak_dddq_d[i] < kZoomBelow * limits.dddq_max[i];
  };
  Figure figure = JointPanels(run, "jerk", "jerk of the reference", "rad/s³",
                              {&run.dddq_d, "dddq_d, jerk of the reference"}, {}, false);
  for (std::size_t i = 0; i < kJoints; ++i) {
    const double limit = limits.dddq_max[i];
    const double peak = run.peak_dddq_d[i];
    if (!zooms(i)) figure.values["limits"] = 1;
    AddPanel(figure, PeakOf(i, peak, limit, "rad/s³") + (zooms(i) ? ", limit out of view" : ""),
             PlusMinus(limit), zooms(i) ? RangeTo(peak) : PlusMinus(1.1 * std::max(limit, peak)));
  }
  return figure;
}

Figure ServedFigure(const RunData& run) {
  Figure figure = FigureOf(run, "served", "commands served");
  figure.columns = "t [s],served [%],served or held [%],held,dropped";
  const auto add = [&figure](double time, const FateCounts& span) {
    const double percent = 100.0 / static_cast<double>(span.cycles());
    const auto held = static_cast<double>(span.held);
    const auto served = static_cast<double>(span.served);
    figure.rows.push_back({time, percent * served, percent * (served + held), held,
                           static_cast<double>(span.dropped)});
  };
  for (const FateCounts& span : run.fates.spans()) add(span.begin, span);
  // gnuplot draws a step up to the next time, so the last span needs one.
  add(run.end + 1e-3, run.fates.spans().back());
  figure.tables = {{"delay", TableOf(run.d_EXT, 1)}, {"rate", TableOf(run.success_rate, 1)}};
  std::uint64_t most = 1;
  for (const FateCounts& span : run.fates.spans()) most = std::max({most, span.held, span.dropped});
  double longest = 0;
  for (const Sample& sample : run.d_EXT.Curve(0)) longest = std::max(longest, sample.value);
  double lowest = 1;
  for (const Sample& sample : run.success_rate.Curve(0)) lowest = std::min(lowest, sample.value);
  figure.values.merge(std::map<std::string, double>{
      {"served", static_cast<double>(run.total.served)},
      {"held", static_cast<double>(run.total.held)},
      {"none", static_cast<double>(run.total.none)},
      {"dropped", static_cast<double>(run.total.dropped)},
      {"longest_loss", run.longest_loss},
      {"cycles_per_span", static_cast<double>(run.fates.cycles_per_span())},
      {"most", static_cast<double>(most)},
      {"written", run.d_EXT.Curve(0).empty() ? 0.0 : 1.0},
      {"longest_us", longest},
      {"lowest_rate", lowest}});
  return figure;
}

Figure ViabilityFigure(const RunData& run) {
  const record::FilterCounts::Nearest least =
      run.filter.nearest.value_or(record::FilterCounts::Nearest());
  Figure figure = FigureOf(run, "viability", "viability filter");
  figure.tables = {{"margin", TableOf(run.margin, 1)}, {"kept_back", TableOf(run.kept_back)}};
  figure.values.merge(
      std::map<std::string, double>{{"least", least.margin},
                                    {"least_at", ToSeconds(least.at.time_since_epoch())},
                                    {"kept_back", static_cast<double>(run.filter.kept_back)},
                                    {"commands", static_cast<double>(run.filter.commands)}});
  return figure;
}

std::vector<std::filesystem::path> WritePlots(const std::filesystem::path& log,
                                              const JointLimits& limits,
                                              const std::filesystem::path& folder) {
  limits.Validate();
  const RunData run = ReadRun(log);
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) {
    throw EnvironmentError(fmt::format("cannot create folder {}: {}; choose another one",
                                       folder.string(), error.message()));
  }
  // Under torques, the robot's reference is constant or copies the target; its jerk means nothing.
  std::vector<Figure> figures{
      JointsFigure(run, limits), TrackingFigure(run), VelocitiesFigure(run, limits),
      run.by_torque ? TorquesFigure(run, limits) : JerkFigure(run, limits), ServedFigure(run)};
  if (run.filter.commands > 0) figures.push_back(ViabilityFigure(run));
  std::vector<std::filesystem::path> paths;
  for (const Figure& figure : figures) {
    paths.push_back(folder / (figure.id + ".svg"));
    WriteFigure(figure, paths.back());
  }
  return paths;
}

}  // namespace twin::report
