#include "loop/interface_stages.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "twin/model/transform.h"
#include "twin/reference/low_pass.h"
#include "twin/reference/pose_viability_filter.h"
#include "twin/reference/rate_limiter.h"
#include "twin/reference/rate_matcher.h"
#include "twin/reference/reference_generator.h"
#include "twin/reference/viability_filter.h"

namespace twin::loop {
namespace {

using control::CommandInterface;
using reference::Target;

constexpr std::uint8_t kAllJoints = (1U << kJoints) - 1;

/// Bit i for flag i.
std::uint8_t BitsOf(const std::array<bool, kJoints>& flags) noexcept {
  unsigned bits = 0;
  for (std::size_t i = 0; i < kJoints; ++i) bits |= flags[i] ? 1U << i : 0U;
  return static_cast<std::uint8_t>(bits);
}

template <std::size_t N>
bool AllZero(const std::array<double, N>& values) noexcept {
  return std::ranges::all_of(values, [](double x) { return x == 0; });
}

/// Largest difference of two elements. For poses: m, or an element of the rotation matrix (rad, if
/// small).
template <std::size_t N>
double LargestDifference(const std::array<double, N>& a, const std::array<double, N>& b) noexcept {
  double largest = 0;
  for (std::size_t i = 0; i < N; ++i) largest = std::max(largest, std::abs(a[i] - b[i]));
  return largest;
}

/// True when a reference of velocity `last` can take the velocity `next` and then stand still.
template <std::size_t N>
bool CanStop(const std::array<double, N>& next, const std::array<double, N>& last) noexcept {
  return std::ranges::equal(next, last, [](double dq, double dq_d) {
    return std::abs(dq) <= kRestVelocity &&
           std::abs(dq - dq_d) <= kRestAcceleration * kCycleSeconds;
  });
}

/// Members of all interfaces. @tparam Matcher  the interface's rate matcher.
template <typename Matcher>
class StagesWith : public InterfaceStages {
 protected:
  explicit StagesWith(const TickConfig& config)
      : config_(config), matcher_(MatchedRate(config)), low_pass_(config.low_pass_hz) {}

  TickConfig config_;
  Matcher matcher_;
  reference::LowPass low_pass_;
};

/// Joint positions and velocities.
class JointStages : public StagesWith<reference::RateMatcher> {
 public:
  void Reset(const RobotState& state) noexcept final { matcher_.Reset({state.q_d, {}, {}}); }
  void Match(const Target& target, Target& matched) noexcept final {
    matched.joint = matcher_.Next(target.joint);
  }

 protected:
  explicit JointStages(const TickConfig& config) : StagesWith(config) {
    if (config.viability) viability_.emplace(config.limits, *config.viability);
  }
  [[nodiscard]] Viable ViableOf(const RobotState& state,
                                const std::array<bool, kJoints>& changed) const noexcept {
    return {viability_->Margin(state.q_d, state.dq_d, state.ddq_d), BitsOf(changed)};
  }

  std::optional<reference::ViabilityFilter> viability_;
};

class JointPositionStages final : public JointStages {
 public:
  explicit JointPositionStages(const TickConfig& config)
      : JointStages(config), generator_(config.lambda) {}

  void Generate(const RobotState& state, const Target& matched,
                RobotCommand& command) const noexcept override {
    command.q_c = config_.generator == Generator::kJoint ? generator_.Next(state.q_d, matched.joint)
                                                         : matched.joint.q;
  }
  void Smooth(const RobotState& state, RobotCommand& command) const noexcept override {
    if (low_pass_.is_on()) command.q_c = low_pass_.Filter(command.q_c, state.q_d);
    if (!config_.limiter) return;
    command.q_c = reference::LimitJointPosition(command.q_c, state.q_d, state.dq_d, state.ddq_d,
                                                *config_.limiter);
  }
  Viable KeepViable(const RobotState& state, RobotCommand& command) const noexcept override {
    const auto outcome = viability_->Next(state.q_d, state.dq_d, state.ddq_d, command.q_c);
    command.q_c = outcome.q_c;
    return ViableOf(state, outcome.active);
  }
  void Settle(const RobotState& state, RobotCommand& command) const noexcept override {
    JointVector dq{};
    for (std::size_t i = 0; i < kJoints; ++i) {
      dq[i] = (command.q_c[i] - state.q_d[i]) / kCycleSeconds;
    }
    if (!CanStop(dq, state.dq_d)) command.q_c = state.q_d;
  }
  [[nodiscard]] bool Arrived(const RobotState& state,
                             const Target& matched) const noexcept override {
    return AllZero(matched.joint.dq) &&
           LargestDifference(matched.joint.q, state.q_d) <= config_.finish_tolerance_rad;
  }

 private:
  reference::JointReferenceGenerator generator_;
};

class JointVelocityStages final : public JointStages {
 public:
  explicit JointVelocityStages(const TickConfig& config) : JointStages(config) {}

  void Generate(const RobotState& /*state*/, const Target& matched,
                RobotCommand& command) const noexcept override {
    command.dq_c = matched.joint.dq;
  }
  void Smooth(const RobotState& state, RobotCommand& command) const noexcept override {
    if (low_pass_.is_on()) command.dq_c = low_pass_.Filter(command.dq_c, state.dq_d);
    if (!config_.limiter) return;
    command.dq_c = reference::LimitJointVelocity(command.dq_c, state.q_d, state.dq_d, state.ddq_d,
                                                 *config_.limiter);
  }
  Viable KeepViable(const RobotState& state, RobotCommand& command) const noexcept override {
    const auto outcome = viability_->NextVelocity(state.q_d, state.dq_d, state.ddq_d, command.dq_c);
    command.dq_c = outcome.dq_c;
    return ViableOf(state, outcome.active);
  }
  void Settle(const RobotState& state, RobotCommand& command) const noexcept override {
    if (!CanStop(command.dq_c, state.dq_d)) command.dq_c = {};
  }
  [[nodiscard]] bool Arrived(const RobotState& /*state*/,
                             const Target& matched) const noexcept override {
    return AllZero(matched.joint.dq);
  }
};

class PoseStages final : public StagesWith<reference::PoseRateMatcher> {
 public:
  explicit PoseStages(const TickConfig& config) : StagesWith(config), generator_(config.lambda) {
    if (config.viability) viability_.emplace(config.cartesian, config.limits, *config.viability);
  }

  void Reset(const RobotState& state) noexcept override { matcher_.Reset({state.O_T_EE_c, {}}); }
  void Match(const Target& target, Target& matched) noexcept override {
    matched.pose = matcher_.Next(target.pose);
  }
  void Generate(const RobotState& state, const Target& matched,
                RobotCommand& command) const noexcept override {
    command.O_T_EE_c = config_.generator == Generator::kCartesian
                           ? generator_.Next(state.O_T_EE_c, matched.pose)
                           : matched.pose.O_T_EE;
  }
  void Smooth(const RobotState& state, RobotCommand& command) const noexcept override {
    Transform& O_T_EE = command.O_T_EE_c;
    if (low_pass_.is_on()) O_T_EE = low_pass_.FilterPose(O_T_EE, state.O_T_EE_c);
    if (!config_.limiter) return;
    O_T_EE = reference::LimitCartesianPose(O_T_EE, state.O_T_EE_c, state.O_dP_EE_c,
                                           state.O_ddP_EE_c, *config_.limiter);
  }
  Viable KeepViable(const RobotState& state, RobotCommand& command) const noexcept override {
    const auto outcome = viability_->Next(state, command.O_T_EE_c);
    command.O_T_EE_c = outcome.O_T_EE_c;
    return {viability_->Margin(state), outcome.active ? kAllJoints : std::uint8_t{0}};
  }
  void Settle(const RobotState& state, RobotCommand& command) const noexcept override {
    Vector6 dP = model::WayTo(state.O_T_EE_c, command.O_T_EE_c);
    for (double& x : dP) x /= kCycleSeconds;
    if (!CanStop(dP, state.O_dP_EE_c)) command.O_T_EE_c = state.O_T_EE_c;
  }
  [[nodiscard]] bool Arrived(const RobotState& state,
                             const Target& matched) const noexcept override {
    return AllZero(matched.pose.O_dP_EE) &&
           LargestDifference(matched.pose.O_T_EE, state.O_T_EE_c) <= config_.finish_tolerance_rad;
  }

 private:
  reference::CartesianReferenceGenerator generator_;
  std::optional<reference::PoseViabilityFilter> viability_;
};

class TorqueStages final : public StagesWith<reference::TorqueRateMatcher> {
 public:
  explicit TorqueStages(const TickConfig& config) : StagesWith(config) {}

  void Reset(const RobotState& state) noexcept override { matcher_.Reset(state.tau_J_d); }
  void Match(const Target& target, Target& matched) noexcept override {
    matched.tau_J_d = matcher_.Next(target.tau_J_d);
    matched.joint = target.joint;  // for the record: where the path would be
  }
  void Generate(const RobotState& /*state*/, const Target& matched,
                RobotCommand& command) const noexcept override {
    command.tau_J_d = matched.tau_J_d;
  }
  void Smooth(const RobotState& state, RobotCommand& command) const noexcept override {
    if (low_pass_.is_on()) command.tau_J_d = low_pass_.Filter(command.tau_J_d, state.tau_J_d);
    if (!config_.limiter) return;
    command.tau_J_d = reference::LimitTorque(command.tau_J_d, state.tau_J_d, *config_.limiter);
  }
  /// TickConfig::Validate refuses the filter on torques.
  Viable KeepViable(const RobotState& /*state*/,
                    RobotCommand& /*command*/) const noexcept override {
    return {};
  }
  /// A torque motion has no reference.
  void Settle(const RobotState& /*state*/, RobotCommand& /*command*/) const noexcept override {}
  [[nodiscard]] bool Arrived(const RobotState& /*state*/,
                             const Target& /*matched*/) const noexcept override {
    return true;
  }
};

}  // namespace

double MatchedRate(const TickConfig& config) noexcept {
  return config.rate_matching ? config.source_rate_hz : 1 / kCycleSeconds;
}

std::unique_ptr<InterfaceStages> MakeStages(const TickConfig& config, CommandInterface interface) {
  switch (interface) {
    case CommandInterface::kJointPosition: return std::make_unique<JointPositionStages>(config);
    case CommandInterface::kJointVelocity: return std::make_unique<JointVelocityStages>(config);
    case CommandInterface::kCartesianPose: return std::make_unique<PoseStages>(config);
    case CommandInterface::kTorque: return std::make_unique<TorqueStages>(config);
  }
  return nullptr;
}

}  // namespace twin::loop
