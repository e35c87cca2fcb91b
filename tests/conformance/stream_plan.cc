#include "conformance/stream_plan.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "conformance/dice.h"
#include "conformance/pose_math.h"
#include "contract/backend_harness.h"

namespace twin::test {
namespace {

constexpr std::array<std::string_view, kMischiefs> kNames{
    "edge",          "step",       "not a number", "infinite", "huge", "wrong id", "bad frame",
    "oblique frame", "elbow sign", "elbow switch", "finish",   "loss", "double",   "torque step",
    "stop",          "recover",    "start again",  "set",      "panel"};

Vector3 DrawAxis(Dice& dice, double length) {
  Vector3 v{dice.Between(-1, 1), dice.Between(-1, 1), dice.Between(-1, 1)};
  const double scale = length / std::max(Norm(v), 1e-3);
  for (double& x : v) x *= scale;
  return v;
}

Transform DrawFrame(Dice& dice) {
  Transform X = Turned(kIdentityTransform, DrawAxis(dice, dice.Between(0, 2)));
  for (std::size_t i = 12; i < 15; ++i) X[i] = dice.Between(-0.1, 0.1);
  X[14] = dice.Between(0, 0.2);
  return X;
}

JointVector DrawPose(Dice& dice, const JointLimits& limits) {
  JointVector q = kHarnessStart;
  // Mostly near the ready pose; sometimes anywhere.
  const double spread = dice.Chance(0.8) ? 0.4 : 3;
  for (std::size_t i = 0; i < kJoints; ++i) {
    const double margin = 0.05;
    q[i] = std::clamp(q[i] + dice.Between(-spread, spread), limits.q_min[i] + margin,
                      limits.q_max[i] - margin);
  }
  return q;
}

setting::CollisionBehavior DrawThresholds(Dice& dice) {
  setting::CollisionBehavior b;
  for (std::size_t i = 0; i < kJoints; ++i) {
    b.lower_torque_acc[i] = dice.Between(0, 8);
    b.upper_torque_acc[i] = b.lower_torque_acc[i] + dice.Between(0, 8);
    b.lower_torque_nominal[i] = dice.Between(0, 8);
    b.upper_torque_nominal[i] = b.lower_torque_nominal[i] + dice.Between(0, 8);
  }
  for (std::size_t i = 0; i < 6; ++i) {
    b.lower_force_acc[i] = dice.Between(0, 12);
    b.upper_force_acc[i] = b.lower_force_acc[i] + dice.Between(0, 12);
    b.lower_force_nominal[i] = dice.Between(0, 12);
    b.upper_force_nominal[i] = b.lower_force_nominal[i] + dice.Between(0, 12);
  }
  return b;
}

setting::Filters DrawFilters(Dice& dice) {
  const auto cutoff = [&] { return dice.Chance(0.5) ? 1000.0 : dice.Between(20, 999); };
  return {cutoff(), cutoff(), cutoff(), cutoff(), cutoff()};
}

setting::Load DrawLoad(Dice& dice) {
  setting::Load load;
  load.m_load = dice.Between(0, 2);
  load.F_x_Cload = {dice.Between(-0.05, 0.05), dice.Between(-0.05, 0.05), dice.Between(0, 0.2)};
  load.I_load = {0.01, 0, 0, 0, 0.01, 0, 0, 0, 0.01};
  return load;
}

void DrawSettings(Dice& dice, StreamPlan& plan) {
  if (dice.Chance(0.2)) plan.settings.emplace_back(DrawFilters(dice));
  if (dice.Chance(0.2)) plan.settings.emplace_back(setting::EndEffectorFrame{DrawFrame(dice)});
  if (dice.Chance(0.1)) plan.settings.emplace_back(setting::StiffnessFrame{DrawFrame(dice)});
  if (dice.Chance(0.1)) {
    setting::JointImpedance impedance;
    for (double& K : impedance.K_theta) K = dice.Between(0, 14250);
    plan.settings.emplace_back(impedance);
  }
  // A load that is not there shows as an external torque.
  if (dice.Chance(0.08)) {
    plan.settings.emplace_back(DrawThresholds(dice));
    plan.settings.emplace_back(DrawLoad(dice));
  }
}

/// Limits are data of a robot: smaller ones let a stream meet those that the Panda's others hide.
void DrawLimits(Dice& dice, StreamPlan& plan) {
  onboard::OnboardConfig& config = plan.robot.onboard;
  if (dice.Chance(0.5)) {
    for (CartesianBound* bound :
         {&config.cartesian.translation, &config.cartesian.rotation, &config.cartesian.elbow}) {
      bound->dp_max *= dice.Between(0.02, 0.3);
      bound->ddp_max *= dice.Between(0.1, 1);
      bound->dddp_max *= dice.Between(0.1, 1);
    }
  }
  if (dice.Chance(0.3)) {
    JointLimits& limits = config.limits;
    for (std::size_t i = 0; i < kJoints; ++i) {
      const double q = plan.robot.q_start[i];
      limits.q_min[i] = std::max(limits.q_min[i], q - dice.Between(0.02, 1));
      limits.q_max[i] = std::min(limits.q_max[i], q + dice.Between(0.02, 1));
      limits.dq_max[i] *= dice.Between(0.1, 0.6);
      limits.ddq_max[i] *= dice.Between(0.5, 1);
      limits.dddq_max[i] *= dice.Between(0.5, 1);
    }
  }
  if (dice.Chance(0.1)) {
    onboard::MeasuredBounds& bounds = config.sensing.measured;
    bounds.translation_max_m_per_s = dice.Between(0.1, 2);
    bounds.power_max_W = dice.Between(5, 350);
    bounds.velocity_margin = 0;
    bounds.q_margin_rad = 0;
    JointVector range = config.limits.tau_max;
    for (double& tau : range) tau *= dice.Between(0.3, 1.2);
    bounds.tau_J_range = range;
  }
}

Disturbance DrawDisturbance(Dice& dice, const StreamPlan& plan) {
  Disturbance d;
  d.cycle = dice.Whole(0, plan.cycles);
  // What ends nearly every stream it is in is drawn less often.
  d.mischief =
      dice.Chance(0.4) ? Mischief::kEdge : static_cast<Mischief>(dice.Whole(1, kMischiefs - 1));
  d.axis = static_cast<std::size_t>(dice.Whole(0, IsCartesian(plan.modes.generator) ? 2 : 6));
  d.edge = static_cast<Edge>(dice.Whole(0, 3));
  switch (d.mischief) {
    case Mischief::kEdge: d.size = dice.NearlyOne(); break;
    case Mischief::kStep: d.size = dice.Magnitude(1e-12, 10); break;
    case Mischief::kTorqueStep: d.size = dice.Magnitude(1e-3, 100); break;
    case Mischief::kWrongId: d.size = dice.Whole(-30, 30); break;
    case Mischief::kObliqueFrame: d.size = dice.Magnitude(1e-12, 1e-4); break;
    case Mischief::kLoss:
      d.count = dice.Chance(0.3) ? dice.Whole(18, 22) : dice.Whole(1, 12);
      break;
    case Mischief::kDouble: d.count = dice.Whole(2, 5); break;
    case Mischief::kPanel: d.count = dice.Whole(0, kPanelActions - 1); break;
    default: d.count = dice.Whole(0, 1 << 30); break;
  }
  return d;
}

void DrawDisturbances(Dice& dice, StreamPlan& plan) {
  if (!plan.hostile) {
    // A sound stream still meets some losses.
    for (int i = dice.Whole(-2, 2); i > 0; --i) {
      plan.disturbances.push_back(
          {dice.Whole(1, plan.cycles), Mischief::kLoss, 0, 0, dice.Whole(1, 3), Edge{}});
    }
    return;
  }
  for (int i = dice.Whole(1, 4); i > 0; --i) {
    plan.disturbances.push_back(DrawDisturbance(dice, plan));
  }
  if (dice.Chance(0.1)) plan.answers_idle = true;
  if (dice.Chance(0.15)) {
    plan.start_offset = dice.Chance(0.5) ? 0.1 * dice.NearlyOne() : dice.Magnitude(1e-6, 1);
    plan.start_axis = static_cast<std::size_t>(dice.Whole(0, 6));
  }
}

}  // namespace

std::string_view Name(Mischief mischief) {
  return kNames[static_cast<std::size_t>(mischief)];
}

double Dice::NearlyOne() {
  return 1 + Magnitude(1e-8, 1e-2);
}

double Dice::Magnitude(double low, double high) {
  const double magnitude = std::exp(Between(std::log(low), std::log(high)));
  return Chance(0.5) ? magnitude : -magnitude;
}

StreamPlan DrawPlan(std::uint64_t seed) {
  Dice dice(seed);
  StreamPlan plan;
  plan.seed = seed;
  plan.robot = HarnessRobot(robot::PlantKind::kIdeal);
  plan.modes = {static_cast<ControllerMode>(dice.Whole(0, 2)),
                static_cast<MotionGeneratorMode>(dice.Whole(1, 4))};
  plan.with_elbow = dice.Chance(0.5);
  plan.hostile = dice.Chance(0.55);
  plan.robot.q_start = DrawPose(dice, plan.robot.onboard.limits);
  if (dice.Chance(0.3)) plan.robot.onboard.F_T_NE = DrawFrame(dice);
  DrawLimits(dice, plan);
  const double most = IsCartesian(plan.modes.generator) && dice.Chance(0.9) ? 0.15 : 1;
  plan.vigour = dice.Chance(0.1) ? 1 : dice.Between(0.02, most);
  plan.idle_cycles = dice.Whole(0, 2);
  plan.waiting_cycles = dice.Chance(0.01) ? dice.Whole(995, 1005) : dice.Whole(0, 4);
  plan.cycles = 500 + dice.Whole(0, 40);
  plan.end = dice.Chance(0.8)   ? StreamEnd::kFinish
             : dice.Chance(0.7) ? StreamEnd::kStop
                                : StreamEnd::kSilence;
  plan.goes_on = dice.Chance(0.1);
  DrawSettings(dice, plan);
  DrawDisturbances(dice, plan);
  return plan;
}

Setting DrawSetting(std::uint64_t number) {
  Dice dice(number);
  const double bad = dice.Chance(0.5) ? std::numeric_limits<double>::quiet_NaN() : -1e9;
  const bool is_bad = dice.Chance(0.3);
  switch (dice.Whole(0, 7)) {
    case 0: {
      setting::JointImpedance s;
      s.K_theta[3] = is_bad ? bad : dice.Between(0, 14250);
      return s;
    }
    case 1: {
      setting::CartesianImpedance s;
      s.K_x[1] = is_bad ? bad : dice.Between(10, 3000);
      return s;
    }
    case 2: {
      setting::CollisionBehavior s = DrawThresholds(dice);
      if (is_bad) s.upper_force_nominal[2] = bad;
      return s;
    }
    case 3: return setting::GuidingMode();
    case 4: {
      setting::StiffnessFrame s{DrawFrame(dice)};
      if (is_bad) s.EE_T_K[3] = bad;
      return s;
    }
    case 5: {
      setting::EndEffectorFrame s{DrawFrame(dice)};
      if (is_bad) s.NE_T_EE[0] = bad;
      return s;
    }
    case 6: {
      setting::Load s = DrawLoad(dice);
      if (is_bad) s.m_load = bad;
      return s;
    }
    default: {
      setting::Filters s = DrawFilters(dice);
      if (is_bad) s.controller_hz = bad;
      return s;
    }
  }
}

std::string Describe(const StreamPlan& plan) {
  std::string text =
      fmt::format("stream {}: {} with {}{}, vigour {:.3g}, {} cycles, from q = [{:.6g}]\n",
                  plan.seed, twin::Name(plan.modes.generator), twin::Name(plan.modes.controller),
                  plan.with_elbow && IsCartesian(plan.modes.generator) ? " and elbow" : "",
                  plan.vigour, plan.cycles, fmt::join(plan.robot.q_start, ", "));
  text += fmt::format(
      "  idle {}, waiting {}, answers idle {}, start offset {:.9g} in {}, then {}\n",
      plan.idle_cycles, plan.waiting_cycles, plan.answers_idle, plan.start_offset, plan.start_axis,
      plan.end == StreamEnd::kFinish ? "finish"
      : plan.end == StreamEnd::kStop ? "stop"
                                     : "silence");
  for (const Setting& setting : plan.settings) {
    text += fmt::format("  set before: {}\n", twin::Name(setting));
  }
  for (const Disturbance& d : plan.disturbances) {
    text += fmt::format("  cycle {}: {} (axis {}, size {:.9g}, count {}, edge {})\n", d.cycle,
                        Name(d.mischief), d.axis, d.size, d.count, static_cast<int>(d.edge));
  }
  return text;
}

}  // namespace twin::test
