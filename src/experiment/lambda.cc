#include "experiment/lambda.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "experiment/chain_bench.h"
#include "experiment/runs.h"
#include "twin/core/half_norm.h"
#include "twin/model/inverse_kinematics.h"
#include "twin/reference/cartesian_reference_generator.h"
#include "twin/report/chart.h"
#include "twin/scenario/robot_data.h"

namespace twin::experiment {
namespace {

constexpr std::array<double, 10> kLambdas{1e-4, 2e-4, 5e-4, 1e-3, 2e-3,
                                          5e-3, 1e-2, 2e-2, 5e-2, 1e-1};
constexpr double kPaperLambda = 1e-3;
constexpr std::array<int, 2> kStallsMs{50, 200};
constexpr double kLeft = 0.05;  ///< share of an offset at which it counts as gone

/// What becomes of an offset at one lambda.
struct Convergence {
  double lambda = 0;
  double formula_s = 0;      ///< until 5 % are left: ln(0.05) / ln(1 - lambda) cycles
  double joint_s = 0;        ///< measured, joint position
  double translation_s = 0;  ///< measured, pose
  double rotation_s = 0;     ///< the same
  double jerk_per_rad = 0;   ///< of the first step, rad/s^3 per rad of offset
};

double FormulaTime(double lambda) {
  return std::log(kLeft) / std::log1p(-lambda) * kCycleSeconds;
}

/// Cycles until `left(cycle)` of an offset is at most 5 %, s.
template <typename Left>
double TimeUntilGone(double lambda, Left left) {
  const int most = static_cast<int>(4 * FormulaTime(lambda) / kCycleSeconds) + 10;
  for (int cycle = 1; cycle <= most; ++cycle) {
    if (left() <= kLeft) return cycle * kCycleSeconds;
  }
  return most * kCycleSeconds;
}

Convergence Converge(double lambda) {
  constexpr double kOffset = 1e-3;  // rad, m
  Convergence convergence{.lambda = lambda, .formula_s = FormulaTime(lambda)};
  ChainBench bench(lambda, 0);
  double jerk = 0;
  convergence.joint_s = TimeUntilGone(lambda, [&] {
    bench.Step(kOffset, 0, true);
    jerk = std::max(jerk, std::abs(bench.jerk()));
    return (kOffset - bench.q_d()) / kOffset;
  });
  convergence.jerk_per_rad = jerk / kOffset;

  const reference::CartesianReferenceGenerator generator(lambda);
  reference::PoseTarget target;
  target.O_T_EE[12] = kOffset;
  Transform pose = kIdentityTransform;
  const auto left = [&](std::size_t half) {
    pose = generator.Next(pose, target);
    return HalfNorm(model::Displacement(pose, target.O_T_EE), half);
  };
  convergence.translation_s = TimeUntilGone(lambda, [&] { return left(0) / kOffset; });
  constexpr double kTurn = 0.5;  // rad, about z
  target.O_T_EE = kIdentityTransform;
  target.O_T_EE[0] = target.O_T_EE[5] = std::cos(kTurn);
  target.O_T_EE[1] = std::sin(kTurn);
  target.O_T_EE[4] = -std::sin(kTurn);
  pose = kIdentityTransform;
  convergence.rotation_s = TimeUntilGone(lambda, [&] { return left(3) / kTurn; });
  return convergence;
}

/// How commands are made of a source that stops for a while.
struct StallChain {
  std::string_view name;
  loop::Generator generator;
  bool limiter;
  std::string_view colour;
};
constexpr std::array kStallChains{
    StallChain{"the paper's law", loop::Generator::kJoint, false, report::colour::kBare},
    StallChain{"the paper's law, client's limiter", loop::Generator::kJoint, true,
               report::colour::kSynchronous},
    StallChain{"rejoining, viability", loop::Generator::kRejoining, false,
               report::colour::kAsynchronous},
};
constexpr std::size_t kOurs = 2;

/// One cycle of such a source.
struct StallRow {
  double t = 0;        ///< since the source stopped, s
  double planned = 0;  ///< velocity, rad/s
  double dq_d = 0;     ///< of the robot's reference, rad/s
  double error = 0;    ///< of its position from the plan, rad
  double jerk = 0;     ///< rad/s^3
};

struct Stall {
  std::vector<StallRow> rows;  ///< from 0.1 s before the source stops to 9 s after
  double largest_jerk = 0;     ///< rad/s^3
  double largest_error = 0;    ///< rad
  double recovered_s = 0;      ///< after the source is back, until the error stays within 4 mrad
};

loop::TickConfig ConfigOf(const StallChain& chain, const scenario::RobotData& robot) {
  loop::TickConfig config;
  config.generator = chain.generator;
  config.lambda = kPaperLambda;
  config.limits = robot.limits;
  config.cartesian = robot.cartesian;
  if (chain.limiter) config.limiter = reference::ClientLimits::Of(robot.limits, robot.cartesian);
  if (chain.generator == loop::Generator::kRejoining) {
    config.viability = reference::ViabilityFilter::kLostByDefault;
  }
  return config;
}

/// Joint 1 swings by 0.8 rad with 1 rad/s at most; the source stops at full speed.
Stall MeasureStall(const loop::TickConfig& config, const JointVector& rest, int stall_ms) {
  constexpr double kAmplitude = 0.8;
  constexpr double kOmega = 1.25;
  constexpr int kStopsMs = 5027;  // two periods: the plan is at its fastest
  constexpr int kBeforeMs = 100;
  constexpr int kAfterMs = 9000;
  constexpr double kClose = 4e-3;  // more than the resampler's lag of 2.25 ms at 1 rad/s
  Stall stall;
  ChainBench bench(config, rest);
  double q_ext = 0;
  double dq_ext = 0;
  for (int ms = 1; ms <= kStopsMs + stall_ms + kAfterMs; ++ms) {
    // The first second fades in: the bench starts at rest.
    const double t = ms * kCycleSeconds;
    const double x = std::min(t, 1.0);
    const double share = x * x * x * (10 + x * (-15 + 6 * x));
    const double rate = t < 1 ? 30 * x * x * (1 - x) * (1 - x) : 0;
    const double q = kAmplitude * share * std::sin(kOmega * t);
    const double dq =
        kAmplitude * (rate * std::sin(kOmega * t) + share * kOmega * std::cos(kOmega * t));
    const bool fresh = ms <= kStopsMs || ms > kStopsMs + stall_ms;
    if (fresh) {
      q_ext = rest[0] + q;
      dq_ext = dq;
    }
    bench.Step(q_ext, dq_ext, fresh);
    if (ms < kStopsMs - kBeforeMs) continue;
    const double error = bench.q_d() - rest[0] - q;
    stall.largest_jerk = std::max(stall.largest_jerk, std::abs(bench.jerk()));
    stall.largest_error = std::max(stall.largest_error, std::abs(error));
    if (std::abs(error) > kClose) stall.recovered_s = (ms - kStopsMs - stall_ms) * kCycleSeconds;
    stall.rows.push_back({(ms - kStopsMs) * kCycleSeconds, dq, bench.dq_d(), error, bench.jerk()});
  }
  return stall;
}

/// By length of the stall and chain.
using Stalls = std::array<std::array<Stall, kStallChains.size()>, kStallsMs.size()>;

Stalls MeasureStalls(const scenario::RobotData& robot) {
  Stalls stalls;
  for (std::size_t i = 0; i < stalls.size(); ++i) {
    for (std::size_t c = 0; c < kStallChains.size(); ++c) {
      stalls[i][c] =
          MeasureStall(ConfigOf(kStallChains[c], robot), MiddleOf(robot.limits), kStallsMs[i]);
    }
  }
  return stalls;
}

report::ChartCurve Curve(std::string name, std::string_view colour,
                         report::ChartCurve::Style style = report::ChartCurve::Style::kLine) {
  return {.name = std::move(name), .colour = colour, .style = style, .x = {}, .y = {}};
}

Figure DrawConvergence(const std::vector<Convergence>& all) {
  using Style = report::ChartCurve::Style;
  Figure figure{.id = "convergence",
                .title = "How fast an offset goes, over lambda",
                .what =
                    "The time falls as 1/lambda, for joints and poses alike; what an offset "
                    "costs in jerk rises with lambda.",
                .svg = {},
                .columns =
                    "lambda,formula [s],joint [s],translation [s],rotation [s],"
                    "jerk per offset [1/s^3]",
                .rows = {}};
  report::ChartCurve formula = Curve("ln 0.05 / ln(1 - lambda)", report::colour::kReference);
  report::ChartCurve joint = Curve("joint", report::colour::kBare, Style::kPoints);
  report::ChartCurve rotation = Curve("rotation", report::colour::kSynchronous, Style::kPoints);
  report::ChartCurve jerk = Curve("", report::colour::kBare, Style::kPoints);
  for (const Convergence& c : all) {
    figure.rows.push_back(
        {c.lambda, c.formula_s, c.joint_s, c.translation_s, c.rotation_s, c.jerk_per_rad});
    for (report::ChartCurve* curve : {&formula, &joint, &rotation, &jerk}) {
      curve->x.push_back(c.lambda);
    }
    formula.y.push_back(c.formula_s);
    joint.y.push_back(c.joint_s);
    rotation.y.push_back(c.rotation_s);
    jerk.y.push_back(c.jerk_per_rad * 1e-3);
  }
  report::Chart chart{
      .title = "An offset between the reference and the last command", .columns = 2, .panels = {}};
  chart.panels.push_back({.title = "until 5 % are left",
                          .x_label = "lambda per cycle",
                          .y_label = "time [s]",
                          .log_x = true,
                          .log_y = true,
                          .curves = {formula, joint, rotation}});
  chart.panels.push_back({.title = "largest jerk of an offset of 1 mrad",
                          .x_label = "lambda per cycle",
                          .y_label = "jerk [rad/s^3]",
                          .log_x = true,
                          .log_y = true,
                          .curves = {jerk}});
  figure.svg = report::DrawChart(chart);
  return figure;
}

Figure DrawStalls(const Stalls& stalls, double jerk_limit) {
  Figure figure{
      .id = "stalls",
      .title = "A source that stops for 50 and 200 ms at 1 rad/s",
      .what =
          "Behind each chain the velocity decays while nothing comes. When the source is back, "
          "the paper's law alone steps to its velocity, far beyond the jerk limit.",
      .columns =
          "stall [ms],chain [-],t [s],planned [rad/s],dq_d [rad/s],error [rad],jerk [rad/s^3]"};
  constexpr std::array kShown{-0.1, 1.5};  // s
  report::Chart chart{
      .title = "The source stops at t = 0", .columns = 2, .width = 1000, .panel_height = 260};
  for (std::size_t i = 0; i < stalls.size(); ++i) {
    report::ChartCurve planned =
        Curve("planned", report::colour::kReference, report::ChartCurve::Style::kDashed);
    for (const StallRow& row : stalls[i][0].rows) {
      planned.x.push_back(row.t);
      planned.y.push_back(row.planned);
    }
    report::ChartPanel velocity{.title = fmt::format("{} ms", kStallsMs[i]),
                                .x_label = "t [s]",
                                .y_label = "velocity [rad/s]",
                                .x_range = kShown,
                                .curves = {planned}};
    report::ChartPanel jerk{
        .title = fmt::format("{} ms, limit {:.0f} rad/s^3", kStallsMs[i], jerk_limit),
        .x_label = "t [s]",
        .y_label = "jerk [rad/s^3]",
        .x_range = kShown,
        .y_range = {{-1.5 * jerk_limit, 1.5 * jerk_limit}}};
    for (std::size_t c = 0; c < kStallChains.size(); ++c) {
      report::ChartCurve dq_d = Curve(std::string(kStallChains[c].name), kStallChains[c].colour);
      report::ChartCurve dddq_d = Curve("", kStallChains[c].colour);
      for (const StallRow& row : stalls[i][c].rows) {
        figure.rows.push_back({static_cast<double>(kStallsMs[i]), static_cast<double>(c), row.t,
                               row.planned, row.dq_d, row.error, row.jerk});
        dq_d.x.push_back(row.t);
        dq_d.y.push_back(row.dq_d);
        dddq_d.x.push_back(row.t);
        dddq_d.y.push_back(row.jerk);
      }
      velocity.curves.push_back(std::move(dq_d));
      jerk.curves.push_back(std::move(dddq_d));
    }
    chart.panels.push_back(std::move(velocity));
    chart.panels.push_back(std::move(jerk));
  }
  figure.svg = report::DrawChart(chart);
  return figure;
}

/// A motion of 8 s commanded as poses, that of models/scenarios/cartesian.yaml, by the calibrated
/// loop. @returns whether it ended well.
bool RunPoses(const Setting& setting) {
  scenario::Scenario scenario = LoadScenario(setting, "asynchronous");
  scenario.seed = SeedOfRun(setting, 0);
  scenario.motion = scenario::Load(setting.files.models / "scenarios" / "cartesian.yaml").motion;
  scenario.tick.generator = loop::Generator::kCartesian;
  return RunScenario(setting, scenario, nullptr).report.succeeded();
}

void Compare(const std::vector<Convergence>& all, const Stalls& stalls, double limit,
             bool poses_end_well, std::vector<Comparison>& out) {
  double joint = 0;
  double pose = 0;
  for (const Convergence& c : all) {
    // A cycle is the grain of the measurement.
    const double grain = kCycleSeconds / c.formula_s;
    joint = std::max(joint, std::abs(c.joint_s / c.formula_s - 1) - grain);
    pose = std::max({pose, std::abs(c.translation_s / c.formula_s - 1) - grain,
                     std::abs(c.rotation_s / c.formula_s - 1) - grain});
  }
  const auto percent = [](double share) { return 100 * std::max(share, 0.0); };
  // The generator's own arithmetic: shown, and demanded nothing of.
  out.push_back({.quantity = "Convergence time off its formula beyond one cycle, joints, largest",
                 .unit = "%",
                 .ours = percent(joint)});
  out.push_back({.quantity = "The same, poses", .unit = "%", .ours = percent(pose)});
  const auto paper = std::ranges::find(all, kPaperLambda, &Convergence::lambda);
  out.push_back({"Time until 5 % of an offset are left, lambda = 1e-3",
                 "s",
                 {},
                 paper->joint_s,
                 {},
                 {},
                 "",
                 Verdict::kReported});
  for (std::size_t i = 0; i < stalls.size(); ++i) {
    for (std::size_t c = 0; c < kStallChains.size(); ++c) {
      const Stall& stall = stalls[i][c];
      const std::string name =
          fmt::format("Stall of {} ms at 1 rad/s, {}", kStallsMs[i], kStallChains[c].name);
      Comparison jerk{.quantity = name + ": largest jerk over its limit",
                      .ours = stall.largest_jerk / limit};
      if (c == kOurs) {
        jerk.demand = "at most 1";
        jerk.verdict = Judge(stall.largest_jerk <= limit);
      }
      out.push_back(jerk);
      out.push_back({.quantity = name + ": largest error from the plan",
                     .unit = "mrad",
                     .ours = 1e3 * stall.largest_error});
      out.push_back({.quantity = name + ": time until the error is within 4 mrad again",
                     .unit = "s",
                     .ours = stall.recovered_s});
    }
  }
  out.push_back({"A motion of 8 s as poses behind the Cartesian generator: aborts",
                 "",
                 0,
                 poses_end_well ? 0.0 : 1.0,
                 {},
                 {},
                 "none",
                 Judge(poses_end_well)});
}

}  // namespace

Findings RunLambda(const Setting& setting) {
  std::vector<Convergence> all;
  all.reserve(kLambdas.size());
  for (const double lambda : kLambdas) all.push_back(Converge(lambda));
  const scenario::Scenario loop = LoadScenario(setting, "asynchronous");
  const scenario::RobotData robot =
      scenario::LoadRobotData(setting.files.models, loop.robot.model, loop.robot.hand);
  const double limit = robot.limits.dddq_max[0];
  const Stalls stalls = MeasureStalls(robot);
  if (setting.progress) setting.progress(0.3);
  const bool poses_end_well = RunPoses(setting);
  Findings findings{
      .id = "lambda",
      .title = "The correction lambda of the reference generator",
      .source = "Section 4, reference generation",
      .text =
          "Convergence and stalls are the command chain's own: it is stepped cycle by cycle "
          "against the reference the robot's controller would make of its commands, every "
          "command taken in time. Convergence: an offset of 1 mrad, 1 mm or 0.5 rad between a "
          "target at rest and the last command, until 5 % of it are left. The jerk is that of "
          "the first steps and rises with offset and lambda; at lambda = 1e-3 an offset of 7.5 "
          "mrad reaches the limit of joint 1. Stalls: joint 1 swings, the source stops at 1 "
          "rad/s and comes back on its plan. After 20 ms without a target the velocity decays "
          "within the limits, behind every chain. The paper's law does not say how to go on when "
          "the source returns: alone it steps to the source's velocity, and the robot aborts; the "
          "client's limiter, with which the paper runs it, makes the step legal and leaves the "
          "error to lambda. Poses also: a motion of 8 s commanded as poses through the "
          "calibrated asynchronous loop, on the ideal plant.",
      .comparisons = {},
      .figures = {},
      .failure = {}};
  Compare(all, stalls, limit, poses_end_well, findings.comparisons);
  findings.figures = {DrawConvergence(all), DrawStalls(stalls, limit)};
  if (setting.progress) setting.progress(1);
  return findings;
}

}  // namespace twin::experiment
