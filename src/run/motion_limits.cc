#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "run/resolve.h"
#include "twin/core/error.h"
#include "twin/core/hand_command.h"
#include "twin/model/arm_model.h"
#include "twin/model/lab_limits.h"
#include "twin/model/transform.h"
#include "twin/onboard/stop_proof.h"
#include "twin/run/islands.h"
#include "twin/run/robot_config.h"

namespace twin::run {
namespace {

constexpr double kRounding = 1e-9;  // share of a cap

/// "at 1.250 s of 4.000 s", or "at its start".
std::string WhenText(Duration t, Duration end) {
  if (t == Duration::zero()) return "at its start";
  return fmt::format("at {:.3f} s of {:.3f} s", ToSeconds(t), ToSeconds(end));
}

/// The limits against one motion.
class MotionLimits {
 public:
  MotionLimits(const model::LabLimits& limits, const model::LimitedArm& arm, Duration end)
      : limits_(limits), arm_(arm), end_(end) {}

  void Require(Duration t, const reference::JointTarget& target) const {
    if (const auto least = model::LeastMargin(limits_, arm_, target.q);
        least && least->margin < 0) {
      Refuse(t, model::Describe(limits_, *least), &target.q, "move the waypoints, or the limit");
    }
    if (limits_.dq_max) {
      for (std::size_t i = 0; i < kJoints; ++i) {
        RequireCap(t, onboard::LimitKind::kJointSpeed, static_cast<std::int8_t>(i),
                   std::abs(target.dq[i]), (*limits_.dq_max)[i], &target.q);
      }
    }
    if (!limits_.v_max && !limits_.w_max) return;
    RequireTwist(t,
                 model::ArmModel::Panda().Twist(model::Frame::kEndEffector, target.q, target.dq,
                                                arm_.F_T_EE),
                 &target.q);
  }

  void Require(Duration t, const reference::PoseTarget& target) const {
    const auto least = model::LeastMarginAt(limits_, arm_, target.O_T_EE);
    if (least && least->margin < 0) {
      Refuse(t, model::Describe(limits_, *least), nullptr, "move the poses, or the limit");
    }
    RequireTwist(t, target.O_dP_EE, nullptr);
  }

 private:
  void RequireTwist(Duration t, const Vector6& twist, const JointVector* q) const {
    if (limits_.v_max) {
      RequireCap(t, onboard::LimitKind::kSpeed, -1, HalfNorm(twist, 0), *limits_.v_max, q);
    }
    if (limits_.w_max) {
      RequireCap(t, onboard::LimitKind::kTurn, -1, HalfNorm(twist, 3), *limits_.w_max, q);
    }
  }

  void RequireCap(Duration t, onboard::LimitKind kind, std::int8_t joint, double value, double cap,
                  const JointVector* q) const {
    if (value <= cap * (1 + kRounding)) return;
    Refuse(t,
           onboard::Describe(limits_, {.kind = kind, .axis = joint, .value = value, .bound = cap}),
           q, "give the motion more time, or raise the cap");
  }

  [[noreturn]] void Refuse(Duration t, const std::string& what, const JointVector* q,
                           std::string_view cure) const {
    const std::string joints =
        q == nullptr ? "" : fmt::format(", joints at [{:.4f}] rad", fmt::join(*q, ", "));
    throw model::LimitBreach(
        fmt::format("motion: {}{}: {}; {}", WhenText(t, end_), joints, what, cure));
  }

  const model::LabLimits& limits_;
  const model::LimitedArm arm_;
  const Duration end_;
};

/// Largest speed, acceleration or jerk of the end effector along a motion.
struct EndEffectorPeak {
  bool turns = false;          ///< or moves
  std::size_t derivative = 0;  ///< 0 speed, 1 acceleration, 2 jerk
  double value = 0;            ///< in SI units
  Duration at{};               ///< since the motion began
};

/// Of translation and rotation, by differences of the poses in successive cycles, as INT does.
std::array<EndEffectorPeak, 6> PeaksOf(const reference::Trajectory& trajectory,
                                       const Transform& F_T_EE) {
  std::array<EndEffectorPeak, 6> peaks;
  for (std::size_t i = 0; i < peaks.size(); ++i) {
    peaks[i].turns = i % 2 == 1;
    peaks[i].derivative = i / 2;
  }
  const auto pose_at = [&](Duration t) {
    return model::ArmModel::Panda().Pose(model::Frame::kEndEffector, trajectory.Sample(t).q,
                                         F_T_EE);
  };
  Transform last = pose_at(Duration::zero());
  std::array<Vector6, 3> rates{};
  const Duration end = trajectory.duration() + static_cast<std::int64_t>(rates.size()) * kCycle;
  for (Duration t = kCycle; t < end; t += kCycle) {
    const Transform now = pose_at(t);
    Vector6 change = model::WayTo(last, now);
    for (Vector6& rate : rates) {
      for (std::size_t k = 0; k < change.size(); ++k) {
        const double next = change[k] / kT;
        change[k] = next - rate[k];
        rate[k] = next;
      }
    }
    for (EndEffectorPeak& peak : peaks) {
      const double value = HalfNorm(rates[peak.derivative], peak.turns ? 3 : 0);
      if (value <= peak.value) continue;
      peak.value = value;
      peak.at = t;
    }
    last = now;
  }
  return peaks;
}

double LimitOf(const EndEffectorPeak& peak, const CartesianLimits& limits) {
  const CartesianBound& bound = peak.turns ? limits.rotation : limits.translation;
  return std::array{bound.dp_max, bound.ddp_max, bound.dddp_max}[peak.derivative];
}

/// Factor on all times that brings the peak to the share of its limit.
double StretchOf(const EndEffectorPeak& peak, const CartesianLimits& limits,
                 const reference::Timing& shares) {
  const double share = std::array{shares.velocity_scale, shares.acceleration_scale,
                                  shares.jerk_scale}[peak.derivative];
  return std::pow(peak.value / (LimitOf(peak, limits) * share * reference::kAdmissibleShare),
                  1.0 / static_cast<double>(peak.derivative + 1));
}

std::string Describe(const EndEffectorPeak& peak, const CartesianLimits& limits) {
  constexpr std::array<std::string_view, 3> kNames{"a speed", "an acceleration", "a jerk"};
  constexpr std::array<std::string_view, 3> kPer{"s", "s^2", "s^3"};
  return fmt::format("the end effector {} at {} of {:.6g} {}/{}, its limit is {:.6g}",
                     peak.turns ? "turns" : "moves", kNames[peak.derivative], peak.value,
                     peak.turns ? "rad" : "m", kPer[peak.derivative], LimitOf(peak, limits));
}

model::LimitedArm ArmOf(const scenario::Scenario& scenario, const scenario::RobotData& robot) {
  return {robot.F_T_EE(scenario.onboard.NE_T_EE), scenario.robot.hand != plant::HandKind::kNone};
}

}  // namespace

std::unique_ptr<planning::CollisionWorld> MakeWorld(const scenario::Scenario& scenario,
                                                    const scenario::RobotData& robot,
                                                    const RunFiles& files) {
  const auto& [robots, own] = files.neighbours;
  std::vector<plant::MujocoPlantOptions> arms;
  if (robots.size() > 1) {
    arms = PlantsOf(robots, files);
  } else {
    arms.push_back(MakeRobotConfig(scenario, robot, files).plant);
  }
  auto world = std::make_unique<planning::CollisionWorld>(arms, robots.size() > 1 ? own : 0);
  for (std::size_t i = 0; i < robots.size(); ++i) {
    if (i != own) world->PlaceArm(i, StartOf(robots[i].scenario), kHandStroke);
  }
  world->SetLimits(scenario.limits, ArmOf(scenario, robot));
  return world;
}

void RequireWithinLimits(const scenario::Scenario& scenario, const scenario::RobotData& robot,
                         const Motion& motion) {
  if (scenario.limits.empty() || motion.live != nullptr) return;
  const auto is_zero = [](double share) { return share == 0; };
  const bool stands =
      !motion.poses && std::ranges::all_of(motion.trajectory.peaks().velocity, is_zero);
  const Duration end = stands ? Duration::zero() : motion.trajectory.duration();
  const MotionLimits limits(scenario.limits, ArmOf(scenario, robot), motion.trajectory.duration());
  for (Duration t{}; t < end + kCycle; t += kCycle) {
    motion.poses ? limits.Require(t, motion.poses->Sample(t))
                 : limits.Require(t, motion.trajectory.Sample(t));
  }
}

void RequireVelocitiesByPosition(const JointLimits& limits, const Motion& motion) {
  if (limits.deceleration == JointVector{} || motion.live != nullptr || motion.poses) return;
  const Duration end = motion.trajectory.duration();
  for (Duration t{}; t < end + kCycle; t += kCycle) {
    const reference::JointTarget target = motion.trajectory.Sample(t);
    for (std::size_t i = 0; i < kJoints; ++i) {
      const double dq = target.dq[i];
      const double bound = limits.VelocityLimit(i, target.q[i], dq);
      if (std::abs(dq) <= bound * (1 + kRounding)) continue;
      throw InputError(fmt::format(
          "motion: {}: joint {} moves at {:.4f} rad/s; the robot permits {:.4f} where it is, at "
          "{:.4f} rad in a range of {:.4f} to {:.4f}; give the motion more time, or stay further "
          "from the ends of the range",
          WhenText(t, end), i + 1, dq, bound, target.q[i], limits.q_min[i], limits.q_max[i]));
    }
  }
}

double EndEffectorStretch(const scenario::Scenario& scenario, const scenario::RobotData& robot,
                          const reference::Trajectory& trajectory) {
  const scenario::MotionSection& motion = scenario.motion;
  if (motion.interface != control::CommandInterface::kCartesianPose) return 1;
  double stretch = 0;
  for (const EndEffectorPeak& peak : PeaksOf(trajectory, robot.F_T_EE(scenario.onboard.NE_T_EE))) {
    stretch = std::max(stretch, StretchOf(peak, robot.cartesian, motion.timing));
  }
  constexpr double kBetweenSamples = 1.0001;
  return stretch <= 1 ? 1 : stretch * kBetweenSamples;
}

void RequireEndEffectorWithinLimits(const CartesianLimits& limits, const Transform& F_T_EE,
                                    const Motion& motion) {
  if (motion.interface != control::CommandInterface::kCartesianPose || motion.live != nullptr ||
      motion.poses) {
    return;
  }
  constexpr reference::Timing kWhole{
      .duration = {}, .velocity_scale = 1, .acceleration_scale = 1, .jerk_scale = 1};
  const auto stretch_of = [&](const EndEffectorPeak& peak) {
    return StretchOf(peak, limits, kWhole);
  };
  const auto peaks = PeaksOf(motion.trajectory, F_T_EE);
  const EndEffectorPeak& worst = *std::ranges::max_element(peaks, {}, stretch_of);
  const double stretch = stretch_of(worst);
  if (stretch <= 1) return;
  const Duration end = motion.trajectory.duration();
  throw InputError(
      fmt::format("motion: {}: {}; the same path is admissible from {:.3f} s in all: give the "
                  "motion more time, or command the joints",
                  WhenText(worst.at, end), Describe(worst, limits),
                  std::ceil(ToSeconds(end) * stretch * 1e3) / 1e3));
}

void RequireStartWithinLimits(const scenario::Scenario& scenario, const scenario::RobotData& robot,
                              const JointVector& q) {
  const MotionLimits limits(scenario.limits, ArmOf(scenario, robot), {});
  limits.Require(Duration::zero(), {.q = q});
}

}  // namespace twin::run
