#include "twin/loop/command_chain.h"

#include <algorithm>
#include <cmath>

#include "twin/reference/moving_average.h"
#include "twin/reference/rate_limiter.h"

namespace twin::loop {
namespace {

using control::CommandInterface;

const TickConfig& Validated(const TickConfig& config, CommandInterface interface) {
  config.Validate(interface);
  return config;
}

/// The rate whose updates are spread over the cycles; that of the cycles themselves: none are.
double MatchedRate(const TickConfig& config) noexcept {
  return config.rate_matching ? config.source_rate_hz : 1 / kCycleSeconds;
}

/// Cycles without a deposit after which the source counts as stalled.
std::uint64_t StallCycles(const TickConfig& config) noexcept {
  constexpr double kLeastPeriods = 3;
  const double seconds =
      std::max(ToSeconds(config.stall_time), kLeastPeriods / config.source_rate_hz);
  return static_cast<std::uint64_t>(std::llround(seconds / kCycleSeconds));
}

template <std::size_t N>
bool AllFinite(const std::array<double, N>& values) noexcept {
  return std::ranges::all_of(values, [](double x) { return std::isfinite(x); });
}

template <std::size_t N>
bool AllZero(const std::array<double, N>& values) noexcept {
  return std::ranges::all_of(values, [](double x) { return x == 0; });
}

/// Last row exact; every row and column of the rotation of norm 1.
bool IsTransform(const Transform& T) noexcept {
  constexpr double kTolerance = 1e-5;
  if (T[3] != 0 || T[7] != 0 || T[11] != 0 || T[15] != 1) return false;
  for (std::size_t i = 0; i < 3; ++i) {
    const double column = std::hypot(T[4 * i], T[4 * i + 1], T[4 * i + 2]);
    const double row = std::hypot(T[i], T[i + 4], T[i + 8]);
    if (std::abs(column - 1) > kTolerance || std::abs(row - 1) > kTolerance) return false;
  }
  return true;
}

constexpr std::uint8_t kAllJoints = (1U << kJoints) - 1;

/// Bit i for flag i.
std::uint8_t BitsOf(const std::array<bool, kJoints>& flags) noexcept {
  unsigned bits = 0;
  for (std::size_t i = 0; i < kJoints; ++i) bits |= flags[i] ? 1U << i : 0U;
  return static_cast<std::uint8_t>(bits);
}

/// Slow enough for the robot to be told that the motion is over: it stops within its limits at
/// once.
bool Rests(const RobotState& state) noexcept {
  constexpr double kSlow = 1e-3;  // rad/s; m/s for a pose
  constexpr double kEven = 1;     // rad/s^2; m/s^2
  const auto below = [](const auto& values, double bound) {
    return std::ranges::all_of(values, [bound](double x) { return std::abs(x) <= bound; });
  };
  return below(state.dq_d, kSlow) && below(state.ddq_d, kEven) && below(state.O_dP_EE_c, kSlow) &&
         below(state.O_ddP_EE_c, kEven);
}

/// Largest distance of two poses: of a coordinate in m, of a rotation matrix's element (rad, when
/// it is small).
double Distance(const Transform& a, const Transform& b) noexcept {
  double largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, std::abs(a[i] - b[i]));
  return largest;
}

}  // namespace

CommandChain::CommandChain(const TickConfig& config, CommandInterface interface)
    : config_(Validated(config, interface)),
      interface_(interface),
      stall_cycles_(StallCycles(config)),
      joint_matcher_(MatchedRate(config)),
      torque_matcher_(MatchedRate(config)),
      pose_matcher_(MatchedRate(config)),
      stall_decay_(config.limits, config.cartesian),
      joint_generator_(config.lambda),
      cartesian_generator_(config.lambda),
      low_pass_(config.low_pass_hz) {
  if (config_.generator == Generator::kRejoining) {
    rejoining_.emplace(interface_, config_.source_rate_hz, config_.limits, config_.cartesian);
  }
  if (!config_.viability) return;
  if (interface_ == CommandInterface::kCartesianPose) {
    pose_viability_.emplace(config_.cartesian, config_.limits, *config_.viability);
  } else {
    viability_.emplace(config_.limits, *config_.viability);
  }
}

void CommandChain::Reset(const RobotState& state) noexcept {
  margin_.reset();
  changed_joints_ = 0;
  kept_back_ = 0;
  waited_ = 0;
  if (rejoining_) rejoining_->Reset(state);
  switch (interface_) {
    case CommandInterface::kJointPosition:
    case CommandInterface::kJointVelocity: joint_matcher_.Reset({state.q_d, {}, {}}); break;
    case CommandInterface::kCartesianPose: pose_matcher_.Reset({state.O_T_EE_c, {}}); break;
    case CommandInterface::kTorque: torque_matcher_.Reset(state.tau_J_d); break;
  }
}

void CommandChain::Match(const reference::Target& target) noexcept {
  switch (interface_) {
    case CommandInterface::kJointPosition:
    case CommandInterface::kJointVelocity:
      matched_.joint = joint_matcher_.Next(target.joint);
      break;
    case CommandInterface::kCartesianPose: matched_.pose = pose_matcher_.Next(target.pose); break;
    case CommandInterface::kTorque:
      matched_.tau_J_d = torque_matcher_.Next(target.tau_J_d);
      matched_.joint = target.joint;  // for the record: where the path would be
      break;
  }
}

void CommandChain::Next(const RobotState& state, const reference::Target& target, bool fresh,
                        std::uint64_t cycles, Time source_time, RobotCommand& command) noexcept {
  waited_ = fresh ? 0 : waited_ + cycles;
  if (rejoining_) {
    rejoining_->Observe(state, target, fresh, cycles, source_time, stalled());
    matched_ = rejoining_->source();
    rejoining_->Command(state, command);
  } else {
    MatchAndDecay(target, cycles);
    Generate(state, command);
  }
  if (low_pass_.is_on()) Filter(state, command);
  if (config_.limiter) Limit(state, command);
  if (config_.viability) KeepViable(state, command);
}

void CommandChain::MatchAndDecay(const reference::Target& target, std::uint64_t cycles) noexcept {
  // More than a window of cycles fills it with the same target as a window does.
  const std::uint64_t steps = std::min<std::uint64_t>(cycles, joint_matcher_.window() + 1);
  for (std::uint64_t i = 0; i < steps; ++i) Match(target);
  if (stalled()) {
    for (std::uint64_t i = 0; i < steps; ++i) stall_decay_.Decay();
    matched_ = stall_decay_.target();
  } else {
    stall_decay_.Follow(matched_);
  }
}

void CommandChain::Generate(const RobotState& state, RobotCommand& command) const noexcept {
  switch (interface_) {
    case CommandInterface::kJointPosition:
      command.q_c = config_.generator == Generator::kJoint
                        ? joint_generator_.Next(state.q_d, matched_.joint)
                        : matched_.joint.q;
      break;
    case CommandInterface::kJointVelocity: command.dq_c = matched_.joint.dq; break;
    case CommandInterface::kCartesianPose:
      command.O_T_EE_c = config_.generator == Generator::kCartesian
                             ? cartesian_generator_.Next(state.O_T_EE_c, matched_.pose)
                             : matched_.pose.O_T_EE;
      break;
    case CommandInterface::kTorque: command.tau_J_d = matched_.tau_J_d; break;
  }
}

void CommandChain::KeepViable(const RobotState& state, RobotCommand& command) noexcept {
  bool changed = false;
  if (interface_ == CommandInterface::kCartesianPose) {
    const auto outcome = pose_viability_->Next(state, command.O_T_EE_c);
    command.O_T_EE_c = outcome.O_T_EE_c;
    margin_ = pose_viability_->Margin(state);
    changed = outcome.active;
    changed_joints_ = changed ? kAllJoints : 0;
  } else {
    const bool by_position = interface_ == CommandInterface::kJointPosition;
    const auto outcome =
        by_position ? viability_->Next(state.q_d, state.dq_d, state.ddq_d, command.q_c)
                    : viability_->NextVelocity(state.q_d, state.dq_d, state.ddq_d, command.dq_c);
    (by_position ? command.q_c : command.dq_c) = by_position ? outcome.q_c : outcome.dq_c;
    margin_ = viability_->Margin(state.q_d, state.dq_d, state.ddq_d);
    changed = outcome.any();
    changed_joints_ = BitsOf(outcome.active);
  }
  kept_back_ += changed ? 1 : 0;
}

void CommandChain::Filter(const RobotState& state, RobotCommand& command) const noexcept {
  switch (interface_) {
    case CommandInterface::kJointPosition:
      command.q_c = low_pass_.Filter(command.q_c, state.q_d);
      break;
    case CommandInterface::kJointVelocity:
      command.dq_c = low_pass_.Filter(command.dq_c, state.dq_d);
      break;
    case CommandInterface::kCartesianPose:
      command.O_T_EE_c = low_pass_.FilterPose(command.O_T_EE_c, state.O_T_EE_c);
      break;
    case CommandInterface::kTorque:
      command.tau_J_d = low_pass_.Filter(command.tau_J_d, state.tau_J_d);
      break;
  }
}

void CommandChain::Limit(const RobotState& state, RobotCommand& command) const noexcept {
  const reference::ClientLimits& limits = *config_.limiter;
  switch (interface_) {
    case CommandInterface::kJointPosition:
      command.q_c =
          reference::LimitJointPosition(command.q_c, state.q_d, state.dq_d, state.ddq_d, limits);
      break;
    case CommandInterface::kJointVelocity:
      command.dq_c = reference::LimitJointVelocity(command.dq_c, state.dq_d, state.ddq_d, limits);
      break;
    case CommandInterface::kCartesianPose:
      command.O_T_EE_c = reference::LimitCartesianPose(command.O_T_EE_c, state.O_T_EE_c,
                                                       state.O_dP_EE_c, state.O_ddP_EE_c, limits);
      break;
    case CommandInterface::kTorque:
      command.tau_J_d = reference::LimitTorque(command.tau_J_d, state.tau_J_d, limits);
      break;
  }
}

bool CommandChain::Arrived(const RobotState& state) const noexcept {
  // A wish is not what was sent: where the filter brakes, the reference may pass its target at
  // speed.
  if ((rejoining_ || config_.viability) && !Rests(state)) return false;
  if (rejoining_) return rejoining_->Arrived(state, config_.finish_tolerance_rad);
  const reference::JointTarget& joint = matched_.joint;
  switch (interface_) {
    case CommandInterface::kJointPosition:
      return AllZero(joint.dq) && [&] {
        for (std::size_t i = 0; i < kJoints; ++i) {
          if (std::abs(joint.q[i] - state.q_d[i]) > config_.finish_tolerance_rad) return false;
        }
        return true;
      }();
    case CommandInterface::kJointVelocity: return AllZero(joint.dq);
    case CommandInterface::kCartesianPose:
      return AllZero(matched_.pose.O_dP_EE) &&
             Distance(matched_.pose.O_T_EE, state.O_T_EE_c) <= config_.finish_tolerance_rad;
    case CommandInterface::kTorque: return true;
  }
  return false;
}

bool IsValid(const RobotCommand& command, CommandInterface interface) noexcept {
  switch (interface) {
    case CommandInterface::kJointPosition: return AllFinite(command.q_c);
    case CommandInterface::kJointVelocity: return AllFinite(command.dq_c);
    case CommandInterface::kCartesianPose:
      return AllFinite(command.O_T_EE_c) && IsTransform(command.O_T_EE_c);
    case CommandInterface::kTorque: return AllFinite(command.tau_J_d);
  }
  return false;
}

}  // namespace twin::loop
