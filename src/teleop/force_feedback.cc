#include "twin/teleop/force_feedback.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "twin/core/joint_vector.h"

namespace twin::teleop {
namespace {

/// Half of a wrench, force (0) or torque (3): applies dead zone, scale and limit.
void Reflect(const Vector6& F, std::size_t first, double dead, double scale, double most,
             Vector6& f) {
  const double norm = HalfNorm(F, first);
  if (!(norm > dead)) return;
  const double length = std::min(scale * (norm - dead), most);
  for (std::size_t i = first; i < first + 3; ++i) f[i] = -F[i] / norm * length;
}

}  // namespace

const Vector6& ReflectedWrench::Next(const RobotState& state, bool in_tool_frame, bool is_felt,
                                     double T) noexcept {
  const Vector6& F = in_tool_frame ? state.K_F_ext_hat_K : state.O_F_ext_hat_K;
  Vector6 f{};
  if (is_felt) {
    Reflect(F, 0, config_.dead_force, config_.scale, config_.most_force, f);
    Reflect(F, 3, config_.dead_torque, config_.scale, config_.most_torque, f);
  }
  const double share = 1 - std::exp(-2 * std::numbers::pi * config_.cutoff_hz * T);
  for (std::size_t i = 0; i < f.size(); ++i) f_[i] += share * (f[i] - f_[i]);
  return f_;
}

PassivePort::PassivePort(const FeedbackConfig& config) noexcept : config_(config) {
  E_.fill(config.reserve);
}

const Vector6& PassivePort::Next(const Vector6& handle, const Vector6& wrench, double T) noexcept {
  if (!has_handle_) handle_ = handle;
  has_handle_ = true;
  for (std::size_t i = 0; i < f_.size(); ++i) {
    const double dx = handle[i] - handle_[i];
    E_[i] -= f_[i] * dx;
    least_ = std::min(least_, E_[i] - config_.reserve);
    f_[i] = wrench[i];
    if (!config_.passive) continue;
    const double most = i < 3 ? config_.most_force : config_.most_torque;
    const double damping = i < 3 ? config_.damping : config_.turn_damping;
    if (E_[i] <= 0 && dx != 0) {
      const double paid = std::min(-E_[i] / std::abs(dx), damping * std::abs(dx) / T);
      f_[i] = -std::copysign(std::min(paid, most), dx);
    } else if (E_[i] <= 0) {
      f_[i] = 0;
    } else if (wrench[i] * dx >= 0) {
      f_[i] *= std::min(1.0, 4 * E_[i] / config_.reserve);
    }
  }
  handle_ = handle;
  return f_;
}

void PassivePort::Recentre(const Vector6& handle) noexcept {
  handle_ = handle;
}

Vector6 PassivePort::energy() const noexcept {
  Vector6 energy = E_;
  for (double& E : energy) E -= config_.reserve;
  return energy;
}

}  // namespace twin::teleop
