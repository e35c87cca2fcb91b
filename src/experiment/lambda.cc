#include <cmath>

#include <fmt/format.h>

#include "experiment/studies.h"
#include "experiment/viability.h"
#include "twin/model/inverse_kinematics.h"
#include "twin/reference/reference_generator.h"

namespace twin::experiment {
namespace {

constexpr std::array<double, 10> kLambdas{1e-4, 2e-4, 5e-4, 1e-3, 2e-3,
                                          5e-3, 1e-2, 2e-2, 5e-2, 1e-1};
constexpr double kPaperLambda = 1e-3;
constexpr std::array<int, 2> kStallsMs{50, 200};
constexpr double kLeft = 0.05;  ///< share of an offset that counts as decayed

/// The decay of an offset at one lambda.
struct OffsetDecay {
  double formula_s = 0;      ///< until 5 % are left: ln(0.05) / ln(1 - lambda) cycles
  double joint_s = 0;        ///< measured, joint position
  double translation_s = 0;  ///< measured, pose
  double rotation_s = 0;     ///< the same
  double jerk_per_rad = 0;   ///< of the first step, rad/s^3 per rad of offset
};

double FormulaTime(double lambda) {
  return std::log(kLeft) / std::log1p(-lambda) * kCycleSeconds;
}

/// Time until left() after a cycle is at most 5 %, s.
template <typename Left>
double TimeUntilDecayed(double lambda, Left left) {
  const int most = static_cast<int>(4 * FormulaTime(lambda) / kCycleSeconds) + 10;
  int cycle = 1;
  while (cycle <= most && left() > kLeft) ++cycle;
  return std::min(cycle, most) * kCycleSeconds;
}

OffsetDecay MeasureDecay(double lambda) {
  constexpr double kOffset = 1e-3;  // rad, m
  OffsetDecay decay{.formula_s = FormulaTime(lambda)};
  loop::TickConfig tick;
  tick.lambda = lambda;
  ChainBench bench(tick, {});
  double jerk = 0;
  decay.joint_s = TimeUntilDecayed(lambda, [&] {
    bench.Step(kOffset, 0, true);
    jerk = std::max(jerk, std::abs(bench.jerk()));
    return (kOffset - bench.q_d()) / kOffset;
  });
  decay.jerk_per_rad = jerk / kOffset;

  const reference::CartesianReferenceGenerator generator(lambda);
  reference::PoseTarget target;
  target.O_T_EE[12] = kOffset;
  Transform pose = kIdentityTransform;
  const auto left = [&](std::size_t half) {
    pose = generator.Next(pose, target);
    return HalfNorm(model::Displacement(pose, target.O_T_EE), half);
  };
  decay.translation_s = TimeUntilDecayed(lambda, [&] { return left(0) / kOffset; });
  constexpr double kTurn = 0.5;  // rad, about z
  target.O_T_EE = kIdentityTransform;
  target.O_T_EE[0] = target.O_T_EE[5] = std::cos(kTurn);
  target.O_T_EE[1] = std::sin(kTurn);
  target.O_T_EE[4] = -std::sin(kTurn);
  pose = kIdentityTransform;
  decay.rotation_s = TimeUntilDecayed(lambda, [&] { return left(3) / kTurn; });
  return decay;
}

/// Chains behind a source that stops for a while.
std::vector<Chain> StallChains(const scenario::RobotData& robot) {
  using enum loop::Generator;
  return {{"the paper's law", TickBehind(kJoint, robot)},
          {"the paper's law, client's limiter", WithLimiter(TickBehind(kJoint, robot), robot)},
          {"rejoining, viability", TickBehind(kRejoining, robot)}};
}
constexpr std::size_t kOurStallChain = 2;

struct Stall {
  /// From 0.1 s before the source stopped to 9 s after: time since then, s; planned velocity and
  /// the reference's, rad/s; error of its position from the plan, rad; its jerk, rad/s^3.
  std::vector<std::array<double, 5>> rows;
  double largest_jerk = 0;   ///< rad/s^3
  double largest_error = 0;  ///< rad
  double recovered_s = 0;    ///< from the source's return until the error stays within 4 mrad
};

/// Joint 1 swings by 0.8 rad with 1 rad/s at most; the source stops at full speed.
Stall MeasureStall(const loop::TickConfig& tick, const JointVector& rest, int stall_ms) {
  constexpr double kAmplitude = 0.8;
  constexpr double kOmega = 1.25;
  constexpr int kStopsMs = 5027;  // two periods: the plan is at its fastest
  constexpr int kBeforeMs = 100;
  constexpr int kAfterMs = 9000;
  constexpr double kClose = 4e-3;  // more than the resampler's lag of 2.25 ms at 1 rad/s
  Stall stall;
  ChainBench bench(tick, rest);
  double q_ext = 0;
  double dq_ext = 0;
  for (int ms = 1; ms <= kStopsMs + stall_ms + kAfterMs; ++ms) {
    // The first second fades in: the bench starts at rest.
    const double t = ms * kCycleSeconds;
    const double x = std::min(t, 1.0);
    const double share = SmoothStep(x);
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

/// Adds the stalls of each length behind each chain, and their figure.
void AddStalls(const scenario::RobotData& robot, Findings& findings) {
  const std::vector<Chain> chains = StallChains(robot);
  const double jerk_limit = robot.limits.dddq_max[0];
  Figure figure{.id = "stalls",
                .columns =
                    "stall [ms],chain [-],t [s],planned [rad/s],dq_d [rad/s],error [rad],"
                    "jerk [rad/s^3]",
                .values = {{"jerk_limit", jerk_limit}},
                .names = NamesOf(chains)};
  for (const int stall_ms : kStallsMs) {
    for (std::size_t c = 0; c < chains.size(); ++c) {
      const Stall stall = MeasureStall(chains[c].tick, MiddleOf(robot.limits), stall_ms);
      const std::string name =
          fmt::format("Stall of {} ms at 1 rad/s, {}", stall_ms, chains[c].name);
      findings.Add(name + ": largest jerk over its limit", "", stall.largest_jerk / jerk_limit)
          .Demand(c == kOurStallChain ? "at most 1" : "", stall.largest_jerk <= jerk_limit);
      findings.Add(name + ": largest error from the plan", "mrad", 1e3 * stall.largest_error);
      findings.Add(name + ": time until the error is within 4 mrad again", "s", stall.recovered_s);
      for (const auto& row : stall.rows) {
        figure.rows.push_back(Row(stall_ms, c, row[0], row[1], row[2], row[3], row[4]));
      }
    }
  }
  findings.figures.push_back(std::move(figure));
}

/// A motion of 8 s commanded as poses, that of models/scenarios/cartesian.yaml, by the calibrated
/// loop. @returns whether it ended well.
bool RunPoses(const Config& config) {
  scenario::Scenario scenario = LoadScenario(config, "asynchronous");
  scenario.motion = scenario::Load(config.files.models / "scenarios" / "cartesian.yaml").motion;
  scenario.tick.generator = loop::Generator::kCartesian;
  return RunScenario(config, scenario).report.succeeded();
}

void AddDecay(Findings& findings) {
  Figure figure{.id = "convergence",
                .columns =
                    "lambda,formula [s],joint [s],translation [s],rotation [s],"
                    "jerk per offset [1/s^3]"};
  double joint = 0;
  double pose = 0;
  double papers_s = 0;
  for (const double lambda : kLambdas) {
    const OffsetDecay c = MeasureDecay(lambda);
    figure.rows.push_back(
        {lambda, c.formula_s, c.joint_s, c.translation_s, c.rotation_s, c.jerk_per_rad});
    if (lambda == kPaperLambda) papers_s = c.joint_s;
    // A cycle is the resolution of the measurement.
    const double grain = kCycleSeconds / c.formula_s;
    joint = std::max(joint, std::abs(c.joint_s / c.formula_s - 1) - grain);
    pose = std::max({pose, std::abs(c.translation_s / c.formula_s - 1) - grain,
                     std::abs(c.rotation_s / c.formula_s - 1) - grain});
  }
  // The generator's own arithmetic has no demand.
  findings.Add("Convergence time off its formula beyond one cycle, joints, largest", "%",
               100 * std::max(joint, 0.0));
  findings.Add("The same, poses", "%", 100 * std::max(pose, 0.0));
  findings.Add("Time until 5 % of an offset are left, lambda = 1e-3", "s", papers_s);
  findings.figures.push_back(std::move(figure));
}

}  // namespace

Findings RunLambda(const Config& config) {
  Findings findings;
  AddDecay(findings);
  AddStalls(RobotOf(config, LoadScenario(config, "asynchronous")), findings);
  if (config.progress) config.progress(0.3);
  const bool poses_end_well = RunPoses(config);
  findings
      .Add("A motion of 8 s as poses behind the Cartesian generator: aborts", "",
           poses_end_well ? 0.0 : 1.0)
      .Paper(0)
      .Demand("none", poses_end_well);
  if (config.progress) config.progress(1);
  return findings;
}

}  // namespace twin::experiment
