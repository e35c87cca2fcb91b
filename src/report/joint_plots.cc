#include "report/joint_plots.h"

#include <algorithm>
#include <limits>
#include <string_view>

#include "report/script.h"

namespace twin::report {
namespace {

constexpr int kWidth = 1200;
constexpr int kHeight = 1120;

/// A panel of one joint.
struct Panel {
  std::size_t joint = 0;
  std::string title;
  std::string_view unit;
  double limit_min = -std::numeric_limits<double>::infinity();  ///< infinite: none
  double limit_max = std::numeric_limits<double>::infinity();
  double y_min = 0;
  double y_max = 0;
};

/// What all panels of a figure show.
struct Curves {
  const Envelope* measured = nullptr;  ///< may be null: not shown
  std::string_view measured_name;
  const Envelope* reference = nullptr;
  std::string_view reference_name;
  bool limits_in_view = true;
};

Script BeginFigure(const RunData& run, std::string_view what) {
  Script script(kWidth, kHeight, Title(run, what), 4, 2);
  script.Line("unset key");
  script.Line("set xrange {}", TimeRange(run));
  script.Line("set xlabel 'time / s' offset 0,0.6");
  script.Line("set lmargin 11; set rmargin 2; set tmargin 3; set bmargin 3");
  MarkMotions(script, run);
  MarkAbort(script, run);
  return script;
}

void AddPanel(Script& script, const Panel& panel, const Curves& curves) {
  script.Curve("reference", *curves.reference, panel.joint);
  if (curves.measured != nullptr) script.Curve("measured", *curves.measured, panel.joint);
  script.Line("set title {} offset 0,-0.6", Quote(panel.title));
  script.Line("set ylabel {} offset 0.5,0", Quote(panel.unit));
  script.Line("set yrange [{:.6g}:{:.6g}]", panel.y_min, panel.y_max);
  std::string plot = "plot ";
  for (const double limit : {panel.limit_min, panel.limit_max}) {
    if (limit < panel.y_min || limit > panel.y_max) continue;
    plot += fmt::format("{:.6g} w l dt 2 lw 1.5 lc '{}', ", limit, kLimitColour);
  }
  if (curves.measured != nullptr) {
    plot += fmt::format("$measured w l lw 3.5 lc '{}', ", kMeasuredColour);
  }
  plot += fmt::format("$reference w l lw 1.2 lc '{}'", kReferenceColour);
  script.Line("{}", plot);
}

/// Fills the eighth place of the figure with the legend, which so covers no curve.
std::string EndFigure(Script script, const RunData& run, const Curves& curves) {
  script.Line(
      "unset title; unset xlabel; unset ylabel; unset tics; unset border; unset grid; unset arrow; "
      "unset label");
  script.Line("set key center center Left reverse font ',14' spacing 1.6 samplen 4");
  script.Line("set xrange [0:1]; set yrange [0:1]");
  std::string plot = fmt::format("plot NaN w l lw 2 lc '{}' title {}", kReferenceColour,
                                 Quote(curves.reference_name));
  if (curves.measured != nullptr) {
    plot += fmt::format(", NaN w l lw 4 lc '{}' title {}", kMeasuredColour,
                        Quote(curves.measured_name));
  }
  if (curves.limits_in_view) {
    plot += fmt::format(", NaN w l dt 2 lw 2 lc '{}' title 'limit'", kLimitColour);
  }
  if (run.motions.size() > 1) {
    plot += ", NaN w l dt 3 lw 1 lc '#888888' title 'a motion begins, with its number'";
  }
  if (run.abort) plot += fmt::format(", NaN w l lw 2 lc '{}' title 'abort'", kAbortColour);
  script.Line("{}", plot);
  return script.End();
}

}  // namespace

std::string PositionScript(const RunData& run, const JointLimits& limits) {
  const Curves curves = run.by_torque ? Curves{&run.q, "q, measured", &run.q_ext, "q_ext, target"}
                                      : Curves{&run.q, "q, measured", &run.q_d, "q_d, desired"};
  Script script = BeginFigure(run, "joint positions");
  for (std::size_t i = 0; i < kJoints; ++i) {
    const double margin = 0.06 * (limits.q_max[i] - limits.q_min[i]);
    AddPanel(script,
             {.joint = i,
              .title = fmt::format("joint {}", i + 1),
              .unit = "rad",
              .limit_min = limits.q_min[i],
              .limit_max = limits.q_max[i],
              .y_min = limits.q_min[i] - margin,
              .y_max = limits.q_max[i] + margin},
             curves);
  }
  return EndFigure(std::move(script), run, curves);
}

std::string VelocityScript(const RunData& run, const JointLimits& limits) {
  const Curves curves = run.by_torque
                            ? Curves{&run.dq, "dq, measured", &run.dq_ext, "dq_ext, of the target"}
                            : Curves{&run.dq, "dq, measured", &run.dq_d, "dq_d, desired"};
  const JointVector& peaks = run.by_torque ? run.peak_dq : run.peak_dq_d;
  Script script = BeginFigure(run, "joint velocities");
  for (std::size_t i = 0; i < kJoints; ++i) {
    const double limit = limits.dq_max[i];
    const double range = 1.1 * std::max(limit, peaks[i]);
    AddPanel(script,
             {.joint = i,
              .title = fmt::format("joint {}: peak {:.3g} of {:.4g} rad/s ({:.3g} %)", i + 1,
                                   peaks[i], limit, 100 * peaks[i] / limit),
              .unit = "rad/s",
              .limit_min = -limit,
              .limit_max = limit,
              .y_min = -range,
              .y_max = range},
             curves);
  }
  return EndFigure(std::move(script), run, curves);
}

std::string TrackingScript(const RunData& run) {
  const Curves curves{
      nullptr, "", &run.error,
      run.by_torque ? "q_ext - q, target less measured" : "q_d - q, desired less measured", false};
  Script script = BeginFigure(run, "tracking error");
  for (std::size_t i = 0; i < kJoints; ++i) {
    const double peak = run.peak_error[i];
    const double range = peak > 0 ? 1.15 * peak : 1;
    AddPanel(script,
             {.joint = i,
              .title = run.error.Curve(i).empty()
                           ? fmt::format("joint {}: nothing to compare", i + 1)
                           : fmt::format("joint {}: peak {:.3g} mrad", i + 1, peak),
              .unit = "mrad",
              .y_min = -range,
              .y_max = range},
             curves);
  }
  return EndFigure(std::move(script), run, curves);
}

std::string TorqueScript(const RunData& run, const JointLimits& limits) {
  const Curves curves{&run.tau_J, "tau_J, measured, with gravity", &run.tau_J_d,
                      "tau_J_d, without gravity", false};
  Script script = BeginFigure(run, "torques");
  for (std::size_t i = 0; i < kJoints; ++i) {
    const double peak = run.peak_tau[i];
    const double range = peak > 0 ? 1.15 * peak : 1;
    AddPanel(script,
             {.joint = i,
              .title = fmt::format("joint {}: peak {:.3g} of {:.4g} Nm ({:.3g} %)", i + 1, peak,
                                   limits.tau_max[i], 100 * peak / limits.tau_max[i]),
              .unit = "Nm",
              .limit_min = -limits.tau_max[i],
              .limit_max = limits.tau_max[i],
              .y_min = -range,
              .y_max = range},
             curves);
  }
  return EndFigure(std::move(script), run, curves);
}

std::string JerkScript(const RunData& run, const JointLimits& limits) {
  // Below this share of the limit the curve would be a line on the axis.
  constexpr double kZoomBelow = 0.1;
  Curves curves{nullptr, "", &run.dddq_d, "dddq_d, jerk of the reference", false};
  Script script = BeginFigure(run, "jerk of the reference");
  for (std::size_t i = 0; i < kJoints; ++i) {
    const double limit = limits.dddq_max[i];
    const double peak = run.peak_dddq_d[i];
    const bool zoom = peak > 0 && peak < kZoomBelow * limit;
    curves.limits_in_view = curves.limits_in_view || !zoom;
    const double range = zoom ? 1.15 * peak : 1.1 * std::max(limit, peak);
    AddPanel(
        script,
        {.joint = i,
         .title = fmt::format("joint {}: peak {:.3g} of {:.5g} rad/s³ ({:.3g} %){}", i + 1, peak,
                              limit, 100 * peak / limit, zoom ? ", limit out of view" : ""),
         .unit = "rad/s³",
         .limit_min = -limit,
         .limit_max = limit,
         .y_min = -range,
         .y_max = range},
        curves);
  }
  return EndFigure(std::move(script), run, curves);
}

}  // namespace twin::report
