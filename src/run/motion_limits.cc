#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "run/resolve.h"
#include "twin/core/error.h"
#include "twin/core/hand_command.h"
#include "twin/model/lab_limits.h"
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

void RequireStartWithinLimits(const scenario::Scenario& scenario, const scenario::RobotData& robot,
                              const JointVector& q) {
  const MotionLimits limits(scenario.limits, ArmOf(scenario, robot), {});
  limits.Require(Duration::zero(), {.q = q});
}

}  // namespace twin::run
