#include "loop/limit_guard.h"

#include <algorithm>
#include <cmath>

namespace twin::loop {
namespace {

using control::CommandInterface;
using onboard::BrokenLimit;
using onboard::JointReference;

JointReference ReferenceOf(const RobotState& state) noexcept {
  JointReference reference;
  reference.q_d = state.q_d;
  reference.dq_d = state.dq_d;
  reference.ddq_d = state.ddq_d;
  return reference;
}

/// True when a stop has ended, up to the rounding of what the robot reports.
bool Rests(const JointReference& reference) noexcept {
  constexpr double kStill = 1e-9;  // rad/s
  constexpr double kEven = 1e-3;   // rad/s^2
  return std::ranges::all_of(reference.dq_d, [](double x) { return std::abs(x) <= kStill; }) &&
         std::ranges::all_of(reference.ddq_d, [](double x) { return std::abs(x) <= kEven; });
}

/// The bounds of a commanded stop: a millionth inside, so that rounding exceeds none in the robot.
JointLimits Inside(JointLimits limits) noexcept {
  constexpr double kInside = 1e-6;
  for (double& bound : limits.ddq_max) bound *= 1 - kInside;
  for (double& bound : limits.dddq_max) bound *= 1 - kInside;
  return limits;
}

}  // namespace

LimitGuard::LimitGuard(const TickConfig& config, CommandInterface interface)
    : interface_(interface),
      is_joint_(interface == CommandInterface::kJointPosition ||
                interface == CommandInterface::kJointVelocity),
      joints_(Inside(config.limits)),
      proof_(joints_, *config.lab, {.with_hand = config.lab_hand}) {}

void LimitGuard::Reset(const RobotState& state) noexcept {
  proof_.SetEndEffector(state.F_T_EE);
  completion_ = onboard::KinematicCompletion(state.F_T_EE);
  breach_.reset();
  done_ = false;
}

void LimitGuard::Next(const RobotState& state, RobotCommand& command) noexcept {
  if (!breach_) breach_ = Check(state, command);
  if (!breach_) return;
  if (!is_joint_) {
    done_ = true;
    return;
  }
  const JointReference now = ReferenceOf(state);
  const JointReference next = onboard::StopStep(now, joints_);
  command.q_c = next.q_d;
  command.dq_c = next.dq_d;
  done_ = done_ || Rests(now);
}

JointReference LimitGuard::After(const RobotState& state,
                                 const RobotCommand& command) const noexcept {
  const JointReference now = ReferenceOf(state);
  switch (interface_) {
    case CommandInterface::kJointPosition: return now.AfterPosition(command.q_c);
    case CommandInterface::kJointVelocity: return now.AfterVelocity(command.dq_c);
    case CommandInterface::kCartesianPose:
      return now.AfterPosition(completion_.Complete(now, {}, command.O_T_EE_c, std::nullopt).q_d);
    case CommandInterface::kTorque: break;
  }
  JointReference measured = JointReference::Rest(state.q);
  return measured.AfterVelocity(state.dq);
}

std::optional<BrokenLimit> LimitGuard::Check(const RobotState& state,
                                             const RobotCommand& command) const noexcept {
  if (const auto breach =
          onboard::CheckForces(proof_.limits(), state.O_F_ext_hat_K, state.tau_ext_hat_filtered))
    return breach;
  JointReference after = After(state, command);
  if (interface_ == CommandInterface::kTorque) after.ddq_d = {};
  const int held = interface_ == CommandInterface::kCartesianPose ? kHeldCycles : 0;
  for (int cycle = 0;; ++cycle) {
    if (const auto breach = proof_.Check(after)) return breach;
    if (cycle == held) return {};
    after = after.AfterLoss();
  }
}

}  // namespace twin::loop
