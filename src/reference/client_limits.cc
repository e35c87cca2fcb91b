#include "twin/reference/client_limits.h"

#include <cmath>
#include <string>

#include <fmt/format.h>

#include "twin/core/error.h"
#include "twin/core/time.h"

namespace twin::reference {
namespace {

constexpr double kMargin = 1e-3;
constexpr double kLostPackets = 3;
/// libfranka's value for any robot.
constexpr double kTranslationalVelocity = 2.0;  // m/s

/// A limit less the client's margin.
double Inside(double limit, double margin, const char* field, const std::string& owner) {
  const double left = limit - margin;
  if (left > 0 && std::isfinite(left)) return left;
  throw InputError(
      fmt::format("rate limiter: {} of {} is {}; it must be finite and above {}, which the limiter "
                  "stays inside of it",
                  field, owner, limit, margin));
}

double InsideVelocity(double limit, double client_acceleration, const char* field,
                      const std::string& owner) {
  return Inside(limit, kMargin + kLostPackets * kCycleSeconds * client_acceleration, field, owner);
}

CartesianBound Inside(const CartesianBound& bound, const std::string& owner) {
  CartesianBound inside;
  inside.dddp_max = Inside(bound.dddp_max, kMargin, "dddp_max", owner);
  inside.ddp_max = Inside(bound.ddp_max, kMargin, "ddp_max", owner);
  inside.dp_max = InsideVelocity(bound.dp_max, inside.ddp_max, "dp_max", owner);
  return inside;
}

}  // namespace

ClientLimits ClientLimits::Of(const JointLimits& joint, const CartesianLimits& cartesian) {
  ClientLimits limits;
  for (std::size_t j = 0; j < kJoints; ++j) {
    const std::string owner = fmt::format("joint {}", j + 1);
    limits.dtau_max[j] = Inside(joint.dtau_max[j], kMargin, "dtau_max", owner);
    limits.dddq_max[j] = Inside(joint.dddq_max[j], kMargin, "dddq_max", owner);
    limits.ddq_max[j] = Inside(joint.ddq_max[j], kMargin, "ddq_max", owner);
    limits.dq_max[j] = InsideVelocity(joint.dq_max[j], limits.ddq_max[j], "dq_max", owner);
  }
  CartesianBound translation = cartesian.translation;
  translation.dp_max = kTranslationalVelocity;
  limits.translation = Inside(translation, "the translation");
  limits.rotation = Inside(cartesian.rotation, "the rotation");
  limits.elbow = Inside(cartesian.elbow, "the elbow");
  return limits;
}

}  // namespace twin::reference
