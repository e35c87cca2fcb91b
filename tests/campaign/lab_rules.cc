#include "campaign/lab_rules.h"

#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "twin/model/arm_model.h"

namespace twin::campaign {
namespace {

constexpr double kLabRounding = 1e-9;
constexpr double kNoCap = std::numeric_limits<double>::infinity();

bool IsAbove(double value, double cap) {
  return value > cap * (1 + kLabRounding);
}

}  // namespace

test::Finding FindBeyondLab(const RobotState& state, const model::LabLimits& limits,
                            bool with_hand) {
  if (limits.empty()) return {};
  const auto margin =
      model::LeastMargin(limits, {state.F_T_EE, with_hand}, model::Configuration(state.q_d));
  if (margin && margin->margin < -kLabRounding) {
    return fmt::format("cycle {}: {}", state.message_id, model::Describe(limits, *margin));
  }
  const Vector6& twist = state.O_dP_EE_d;
  const double speed = std::hypot(twist[0], twist[1], twist[2]);
  const double turn = std::hypot(twist[3], twist[4], twist[5]);
  if (IsAbove(speed, limits.v_max.value_or(kNoCap)) ||
      IsAbove(turn, limits.w_max.value_or(kNoCap))) {
    return fmt::format("cycle {}: the end effector moves at {} m/s and turns at {} rad/s",
                       state.message_id, speed, turn);
  }
  for (std::size_t i = 0; i < kJoints && limits.dq_max; ++i) {
    if (!IsAbove(std::abs(state.dq_d[i]), (*limits.dq_max)[i])) continue;
    return fmt::format("cycle {}: joint {} moves at {} rad/s, and the lab allows {}",
                       state.message_id, i + 1, state.dq_d[i], (*limits.dq_max)[i]);
  }
  return {};
}

}  // namespace twin::campaign
