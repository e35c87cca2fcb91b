#include "twin/loop/command_chain.h"

#include <algorithm>
#include <cmath>

#include "loop/interface_stages.h"
#include "loop/limit_guard.h"
#include "twin/reference/moving_average.h"

namespace twin::loop {
namespace {

using control::CommandInterface;

const TickConfig& Validated(const TickConfig& config, CommandInterface interface) {
  config.Validate(interface);
  return config;
}

/// Cycles without a deposit after which the source counts as stalled.
std::uint64_t StallCycles(const TickConfig& config) noexcept {
  constexpr double kLeastPeriods = 3;
  const double seconds =
      std::max(ToSeconds(config.stall_time), kLeastPeriods / config.source_rate_hz);
  return static_cast<std::uint64_t>(std::llround(seconds / kCycleSeconds));
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

/// True when the reference is slow enough to finish the motion: the robot then stops at once within
/// its limits.
bool Rests(const RobotState& state) noexcept {
  const auto below = [](const auto& values, double bound) {
    return std::ranges::all_of(values, [bound](double x) { return std::abs(x) <= bound; });
  };
  return below(state.dq_d, kRestVelocity) && below(state.ddq_d, kRestAcceleration) &&
         below(state.O_dP_EE_c, kRestVelocity) && below(state.O_ddP_EE_c, kRestAcceleration);
}

}  // namespace

CommandChain::CommandChain(const TickConfig& config, CommandInterface interface)
    : config_(Validated(config, interface)),
      stages_(MakeStages(config, interface)),
      window_(reference::RateMatchingWindow(MatchedRate(config))),
      stall_cycles_(StallCycles(config)),
      stall_decay_(config.limits, config.cartesian) {
  if (config_.generator == Generator::kRejoining) {
    rejoining_.emplace(interface, config_.source_rate_hz, config_.limits, config_.cartesian);
  }
  if (config_.lab) guard_ = std::make_unique<LimitGuard>(config_, interface);
}

CommandChain::CommandChain(CommandChain&&) noexcept = default;
CommandChain::~CommandChain() = default;

void CommandChain::Reset(const RobotState& state) noexcept {
  margin_.reset();
  changed_joints_ = 0;
  kept_back_ = 0;
  waited_ = 0;
  if (rejoining_) rejoining_->Reset(state);
  stages_->Reset(state);
  if (guard_) guard_->Reset(state);
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
    stages_->Generate(state, matched_, command);
  }
  stages_->Smooth(state, command);
  if (config_.viability) KeepViable(state, command);
  if (guard_) guard_->Next(state, command);
}

void CommandChain::KeepViable(const RobotState& state, RobotCommand& command) noexcept {
  const Viable viable = stages_->KeepViable(state, command);
  margin_ = viable.margin;
  changed_joints_ = viable.changed_joints;
  kept_back_ += changed_joints_ != 0 ? 1 : 0;
}

void CommandChain::MatchAndDecay(const reference::Target& target, std::uint64_t cycles) noexcept {
  // One window of cycles fills the matcher with the target; more have no further effect.
  const std::uint64_t steps = std::min<std::uint64_t>(cycles, window_ + 1);
  for (std::uint64_t i = 0; i < steps; ++i) stages_->Match(target, matched_);
  if (stalled()) {
    for (std::uint64_t i = 0; i < steps; ++i) stall_decay_.Decay();
    matched_ = stall_decay_.target();
  } else {
    stall_decay_.Follow(matched_);
  }
}

std::optional<onboard::BrokenLimit> CommandChain::breach() const noexcept {
  return guard_ ? guard_->breach() : std::nullopt;
}

bool CommandChain::sends() const noexcept {
  return !guard_ || guard_->sends();
}

bool CommandChain::stopped() const noexcept {
  return guard_ && guard_->done();
}

bool CommandChain::Finish(const RobotState& state, bool is_noisy,
                          RobotCommand& command) const noexcept {
  // The sent command may differ from the requested one: while the filter brakes, the reference may
  // pass its target at speed.
  const bool keeps_limits = rejoining_ || config_.viability;
  if (keeps_limits && !Rests(state)) return false;
  const bool arrived = rejoining_
                           ? rejoining_->Arrived(state, config_.finish_tolerance_rad, is_noisy)
                           : stages_->Arrived(state, matched_);
  if (arrived && keeps_limits) stages_->Settle(state, command);
  return arrived;
}

bool IsValid(const RobotCommand& command, CommandInterface interface) noexcept {
  switch (interface) {
    case CommandInterface::kJointPosition: return IsFinite(command.q_c);
    case CommandInterface::kJointVelocity: return IsFinite(command.dq_c);
    case CommandInterface::kCartesianPose:
      return IsFinite(command.O_T_EE_c) && IsTransform(command.O_T_EE_c);
    case CommandInterface::kTorque: return IsFinite(command.tau_J_d);
  }
  return false;
}

}  // namespace twin::loop
