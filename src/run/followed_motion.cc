#include "twin/run/result.h"

#include <algorithm>
#include <array>
#include <string_view>

#include <fmt/format.h>

#include "twin/core/setting.h"

namespace twin::run {
namespace {

/// Of a robot of the stiffness it is delivered with: 20 mrad, or mm.
constexpr double kDefault = 0.02;

/// How many times softer than as delivered, in its softest direction; at least 1.
template <std::size_t N>
double Softness(const std::array<double, N>& delivered, const std::array<double, N>& stiffness) {
  double softness = 1;
  for (std::size_t i = 0; i < N; ++i) {
    softness = std::max(softness, stiffness[i] > 0 ? delivered[i] / stiffness[i]
                                                   : std::numeric_limits<double>::infinity());
  }
  return softness;
}

double Default(const scenario::Scenario& scenario, control::CommandInterface interface,
               ControllerMode impedance) {
  if (interface == control::CommandInterface::kTorque || !scenario.perturbations.empty()) {
    return std::numeric_limits<double>::infinity();
  }
  const scenario::OnboardSection& onboard = scenario.onboard;
  return kDefault * (impedance == ControllerMode::kCartesianImpedance
                         ? Softness(setting::CartesianImpedance().K_x, onboard.K_x)
                         : Softness(setting::JointImpedance().K_theta, onboard.K_theta));
}

}  // namespace

DeviationLimit LimitOf(const scenario::Scenario& scenario, control::CommandInterface interface,
                       ControllerMode impedance) {
  const double otherwise = Default(scenario, interface, impedance);
  const scenario::MaxDeviation& max = scenario.max_deviation;
  if (interface == control::CommandInterface::kCartesianPose) {
    return {.position = max.position.value_or(otherwise), .angle = max.angle.value_or(otherwise)};
  }
  return {.joints = max.joints.value_or(otherwise)};
}

std::string FollowedMotion::Excess() const {
  std::string text;
  const auto add = [&text](double value, double most, std::string_view unit, std::string where) {
    if (value <= most) return;
    text += fmt::format("{}{:.4g} {} {}, above the limit of {:.4g} {}", text.empty() ? "" : "; ",
                        value * 1e3, unit, where, most * 1e3, unit);
  };
  const auto seconds = [](Time at) { return ToSeconds(at.time_since_epoch()); };
  if (const auto& joints = deviation.joints) {
    add(joints->largest, limit.joints, "mrad",
        fmt::format("(joint {}, at {:.3f} s)", joints->joint + 1, seconds(joints->at)));
  }
  if (const auto& pose = deviation.pose) {
    add(pose->position, limit.position, "mm",
        fmt::format("(position, at {:.3f} s)", seconds(pose->position_at)));
    add(pose->angle, limit.angle, "mrad",
        fmt::format("(angle, at {:.3f} s)", seconds(pose->angle_at)));
  }
  return text;
}

}  // namespace twin::run
