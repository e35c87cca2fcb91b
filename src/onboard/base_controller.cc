#include "twin/onboard/base_controller.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <fmt/format.h>

#include "twin/core/error.h"

namespace twin::onboard {
namespace {

constexpr double kGain = 60;           // Kp, N m s/rad
constexpr double kIntegralGain = 900;  // Ki, N m/rad

void RequirePositive(const char* field, double value) {
  if (std::isfinite(value) && value > 0) return;
  throw InputError(fmt::format("base: {} is {}; it must be above 0", field, value));
}

double Cut(double value, double most) noexcept {
  return std::isfinite(value) ? std::clamp(value, -most, most) : 0;
}

/// Moves `from` towards `to` by at most `step`.
double Approach(double from, double to, double step) noexcept {
  return from + std::clamp(to - from, -step, step);
}

/// Mean of a side's two wheels, in the order of WheelSensors.
double Left(const std::array<double, 4>& wheels) noexcept {
  return (wheels[0] + wheels[2]) / 2;
}
double Right(const std::array<double, 4>& wheels) noexcept {
  return (wheels[1] + wheels[3]) / 2;
}

}  // namespace

void BaseConfig::Validate() const {
  RequirePositive("wheel_radius", wheel_radius);
  RequirePositive("track", track);
  RequireInRange("base: track_factor", track_factor, 1, 10);
  RequirePositive("most.v", most.v);
  RequirePositive("most.w", most.w);
  RequirePositive("ordinary.dv", ordinary.dv);
  RequirePositive("ordinary.dw", ordinary.dw);
  RequirePositive("lost.dv", lost.dv);
  RequirePositive("lost.dw", lost.dw);
  RequirePositive("emergency.dv", emergency.dv);
  RequirePositive("emergency.dw", emergency.dw);
  RequirePositive("tau_max", tau_max);
  RequirePositive("watchdog", ToSeconds(watchdog));
}

BaseController::BaseController(const BaseConfig& config, const WheelSensors& sensors) noexcept
    : config_(config), half_track_(config.track_factor * config.track / 2), q_last_(sensors.q) {}

WheelDrive BaseController::Cycle(const WheelSensors& sensors,
                                 const std::optional<BaseTwist>& command, bool emergency) noexcept {
  ++state_.message_id;
  Measure(sensors);
  Take(command, emergency);
  MoveReference(emergency);
  return Drive();
}

void BaseController::Take(const std::optional<BaseTwist>& command, bool emergency) noexcept {
  ++age_;
  if (command) {
    command_ = {Cut(command->v, config_.most.v), Cut(command->w, config_.most.w)};
    commanded_ = true;
    age_ = 0;
  }
  if (emergency || age_ * kCycle >= config_.watchdog) commanded_ = false;
  state_.mode = emergency    ? BaseMode::kEmergencyStop
                : commanded_ ? BaseMode::kDriving
                             : BaseMode::kStanding;
}

void BaseController::MoveReference(bool emergency) noexcept {
  const BaseAcceleration& most = emergency    ? config_.emergency
                                 : commanded_ ? config_.ordinary
                                              : config_.lost;
  const BaseTwist target = commanded_ ? command_ : BaseTwist{};
  BaseTwist& twist_d = state_.twist_d;
  twist_d.v = Approach(twist_d.v, target.v, most.dv * kCycleSeconds);
  twist_d.w = Approach(twist_d.w, target.w, most.dw * kCycleSeconds);
}

void BaseController::Measure(const WheelSensors& sensors) noexcept {
  Wheels turned{};
  for (std::size_t i = 0; i < turned.size(); ++i) turned[i] = sensors.q[i] - q_last_[i];
  q_last_ = sensors.q;
  state_.dq_wheels = sensors.dq;
  const double R = config_.wheel_radius;
  state_.twist.v = R * (Left(sensors.dq) + Right(sensors.dq)) / 2;
  state_.twist.w = R * (Right(sensors.dq) - Left(sensors.dq)) / (2 * half_track_);
  const double ds = R * (Left(turned) + Right(turned)) / 2;
  const double dyaw = R * (Right(turned) - Left(turned)) / (2 * half_track_);
  BasePose& at = state_.odometry;
  at.x += ds * std::cos(at.yaw + dyaw / 2);
  at.y += ds * std::sin(at.yaw + dyaw / 2);
  at.yaw += dyaw;
}

WheelDrive BaseController::Drive() noexcept {
  const BaseTwist& twist_d = state_.twist_d;
  WheelDrive drive;
  for (std::size_t i = 0; i < drive.tau.size(); ++i) {
    const double side = i % 2 == 0 ? -1 : 1;
    const double dq_d = (twist_d.v + side * twist_d.w * half_track_) / config_.wheel_radius;
    const double error = dq_d - state_.dq_wheels[i];
    const double wanted = kGain * error + kIntegralGain * integral_[i];
    drive.tau[i] = std::clamp(wanted, -config_.tau_max, config_.tau_max);
    const bool winds_up = drive.tau[i] != wanted && error * wanted > 0;
    if (!winds_up) integral_[i] += error * kCycleSeconds;
  }
  return drive;
}

}  // namespace twin::onboard
