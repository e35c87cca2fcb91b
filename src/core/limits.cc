#include "twin/core/limits.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "twin/core/error.h"

namespace twin {
namespace {

void RequirePositive(const char* field, const JointVector& values) {
  for (std::size_t i = 0; i < kJoints; ++i) {
    if (std::isfinite(values[i]) && values[i] > 0) continue;
    throw InputError(
        fmt::format("joint limits: {} of joint {} is {}; it must be a finite number above 0", field,
                    i + 1, values[i]));
  }
}

/// @param distance  to the end of the range towards which the joint moves, rad.
double VelocityTowards(const JointLimits& limits, std::size_t joint, double distance) noexcept {
  if (limits.deceleration[joint] == 0) return limits.dq_max[joint];
  const double braking = std::sqrt(std::max(0.0, 2 * limits.deceleration[joint] * distance));
  return std::clamp(braking - limits.velocity_offset[joint], 0.0, limits.dq_max[joint]);
}

}  // namespace

void JointLimits::Validate() const {
  for (std::size_t i = 0; i < kJoints; ++i) {
    if (std::isfinite(q_min[i]) && std::isfinite(q_max[i]) && q_min[i] < q_max[i]) continue;
    throw InputError(
        fmt::format("joint limits: position range of joint {} is [{}, {}]; q_min must be below "
                    "q_max, both finite",
                    i + 1, q_min[i], q_max[i]));
  }
  RequirePositive("dq_max", dq_max);
  RequirePositive("ddq_max", ddq_max);
  RequirePositive("dddq_max", dddq_max);
  RequirePositive("tau_max", tau_max);
  RequirePositive("dtau_max", dtau_max);
  for (std::size_t i = 0; i < kJoints; ++i) {
    for (const auto& [field, value] :
         {std::pair{"velocity_offset", velocity_offset[i]}, {"deceleration", deceleration[i]}}) {
      if (std::isfinite(value) && value >= 0) continue;
      throw InputError(
          fmt::format("joint limits: {} of joint {} is {}; it must be finite and not negative",
                      field, i + 1, value));
    }
  }
}

double JointLimits::UpperVelocity(std::size_t joint, double q) const noexcept {
  return VelocityTowards(*this, joint, q_max[joint] - q);
}

double JointLimits::LowerVelocity(std::size_t joint, double q) const noexcept {
  return -VelocityTowards(*this, joint, q - q_min[joint]);
}

double JointLimits::VelocityLimit(std::size_t joint, double q, double dq) const noexcept {
  return std::signbit(dq) ? -LowerVelocity(joint, q) : UpperVelocity(joint, q);
}

double JointLimits::StillZone(std::size_t joint) const noexcept {
  const double offset = velocity_offset[joint];
  return deceleration[joint] == 0 ? 0 : offset * offset / (2 * deceleration[joint]);
}

void CartesianLimits::Validate() const {
  const auto require = [](const char* kind, const CartesianBound& bound) {
    for (const auto& [field, value] : {std::pair{"dp_max", bound.dp_max},
                                       {"ddp_max", bound.ddp_max},
                                       {"dddp_max", bound.dddp_max}}) {
      if (std::isfinite(value) && value > 0) continue;
      throw InputError(
          fmt::format("Cartesian limits: {} of the {} is {}; it must be a finite number above 0",
                      field, kind, value));
    }
  };
  require("translation", translation);
  require("rotation", rotation);
  require("elbow", elbow);
}

}  // namespace twin
