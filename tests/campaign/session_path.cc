#include "campaign/session_path.h"

#include <algorithm>
#include <cmath>

#include "twin/core/time.h"

namespace twin::campaign {
namespace {

// Of every joint of both robots, with room; the end effector gets a quarter, for the joints' sake.
constexpr double kAcceleration = 2;  // rad/s^2
constexpr double kJerk = 1000;       // rad/s^3
constexpr double kForEndEffector = 0.25;

// Of 64 x^3 (1 - x)^3 with respect to x.
constexpr double kPeakAcceleration = 24;
constexpr double kPeakJerk = 384;

}  // namespace

SessionPath::SessionPath(test::Dice& dice, const RobotState& state, const MotionModes& modes)
    : generator_(modes.generator),
      q_0_(state.q_d),
      O_T_EE_0_(state.O_T_EE_c),
      cycles_(dice.Chance(0.2) ? dice.Whole(30, 400) : dice.Whole(1, 30)),
      joint_(static_cast<std::size_t>(dice.Whole(0, kJoints - 1))) {
  if (modes.controller == ControllerMode::kExternalController || dice.Chance(0.3)) return;
  const double time = cycles_ * kT;
  length_ = std::min(kAcceleration * time * time / kPeakAcceleration,
                     kJerk * time * time * time / kPeakJerk) *
            (dice.Chance(0.5) ? 1 : -1);
  if (IsCartesian(generator_)) length_ *= kForEndEffector;
}

SessionPath::Point SessionPath::PointAt(int k) const {
  const double x = std::min(1.0, static_cast<double>(k) / cycles_);
  const double u = x * (1 - x);
  return {length_ * 64 * u * u * u, length_ * 192 * u * u * (1 - 2 * x) / (cycles_ * kT)};
}

RobotCommand SessionPath::At(const RobotState& state, int k) const {
  const Point point = PointAt(k);
  RobotCommand command;
  command.q_c = q_0_;
  command.q_c[joint_] += point.way;
  command.dq_c[joint_] = point.rate;
  command.O_T_EE_c = O_T_EE_0_;
  command.O_T_EE_c[14] += point.way;
  command.O_dP_EE_c[2] = point.rate;
  // The arm holds itself without. In one step it would be too much where a controller has held it.
  for (std::size_t i = 0; i < kJoints; ++i) command.tau_J_d[i] = 0.99 * state.tau_J_d[i];
  return command;
}

double SessionPath::Off(const RobotState& state, int k) const {
  const auto [way, rate] = PointAt(k);
  switch (generator_) {
    case MotionGeneratorMode::kJointPosition:
      return std::abs(state.q_d[joint_] - (q_0_[joint_] + way));
    case MotionGeneratorMode::kJointVelocity: return std::abs(state.dq_d[joint_] - rate);
    case MotionGeneratorMode::kCartesianPosition:
      return std::abs(state.O_T_EE_c[14] - (O_T_EE_0_[14] + way));
    case MotionGeneratorMode::kCartesianVelocity: return std::abs(state.O_dP_EE_c[2] - rate);
    default: return 0;
  }
}

}  // namespace twin::campaign
