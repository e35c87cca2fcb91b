#include "twin/plant/perturbation.h"

#include <algorithm>
#include <string_view>

#include <fmt/format.h>

#include "plant/perturber.h"
#include "twin/core/error.h"

namespace twin::plant {
namespace {

constexpr double kMostForce = 1e4;      ///< N or Nm
constexpr double kFarthest = 100;       ///< m
constexpr double kMostStiffness = 2e4;  ///< N/m; above, a step of 1 ms destabilises a body of 100 g
constexpr double kMostDamping = 500;    ///< Ns/m

void RequireVector(std::string_view what, const Vector3& v, double most) {
  for (const double x : v) RequireInRange(what, x, -most, most);
}

template <typename Kind>
void RequireTimes(std::string_view what, const Kind& one) {
  if (one.begin < Duration::zero()) {
    throw InputError(
        fmt::format("{}: begin is {} s; it must not be negative", what, ToSeconds(one.begin)));
  }
  if (one.duration <= Duration::zero()) {
    throw InputError(
        fmt::format("{}: duration is {} s; it must be above 0", what, ToSeconds(one.duration)));
  }
  if (one.motion == 0u) {
    throw InputError(fmt::format(
        "{}: motion is 0; motions count from 1, or leave it out for the time since the start",
        what));
  }
}

void ValidatePush(const Push& push) {
  RequireTimes("push", push);
  if (push.rise < Duration::zero() || push.rise > push.duration / 2) {
    throw InputError(fmt::format(
        "push: rise is {} s; rise and fall take as long, so it must lie in [0, {}] s, half of "
        "duration",
        ToSeconds(push.rise), ToSeconds(push.duration / 2)));
  }
  RequireVector("push: force (N)", push.force, kMostForce);
  RequireVector("push: torque (Nm)", push.torque, kMostForce);
  RequireVector("push: point (m)", push.point, kFarthest);
}

void ValidateSpring(const HandSpring& spring) {
  RequireTimes("spring", spring);
  RequireVector("spring: point (m)", spring.point, kFarthest);
  if (spring.from) RequireVector("spring: from (m)", *spring.from, kFarthest);
  RequireVector("spring: by (m)", spring.by, kFarthest);
  RequireInRange("spring: stiffness (N/m)", spring.stiffness, 0, kMostStiffness);
  RequireInRange("spring: damping (Ns/m)", spring.damping, 0, kMostDamping);
  RequireInRange("spring: largest_force (N)", spring.largest_force, 0, kMostForce);
}

}  // namespace

void Validate(const Perturbation& perturbation) {
  if (const auto* push = std::get_if<Push>(&perturbation)) {
    ValidatePush(*push);
  } else {
    ValidateSpring(std::get<HandSpring>(perturbation));
  }
}

double ShareAt(const Push& push, Duration t) noexcept {
  const Duration since = t - push.begin;
  const Duration left = push.duration - since;
  if (since < Duration::zero() || left < Duration::zero()) return 0;
  const Duration nearest = std::min(since, left);  // to one of the ends
  if (nearest >= push.rise) return 1;
  return MinimumJerk(ToSeconds(nearest) / ToSeconds(push.rise)).s;
}

const std::string& BodyOf(const Perturbation& perturbation) noexcept {
  return std::visit([](const auto& one) -> const std::string& { return one.body; }, perturbation);
}

}  // namespace twin::plant
