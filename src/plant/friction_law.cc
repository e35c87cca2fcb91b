#include "twin/plant/friction_law.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "plant/joint_parameters.h"
#include "twin/core/error.h"
#include "twin/core/time.h"

namespace twin::plant {

JointVector Friction(const FrictionLaw& law, const JointVector& dq) noexcept {
  JointVector tau{};
  for (std::size_t i = 0; i < kJoints; ++i) {
    const double at_dq = 1 / (1 + std::exp(-law.steepness[i] * (dq[i] + law.shift[i])));
    const double at_rest = 1 / (1 + std::exp(-law.steepness[i] * law.shift[i]));
    tau[i] = law.viscous[i] * dq[i] + 2 * law.coulomb[i] * (at_dq - at_rest) + law.offset[i];
  }
  return tau;
}

void Validate(const FrictionLaw& law, const JointVector& armature) {
  for (std::size_t i = 0; i < kJoints; ++i) {
    const auto require = [i](const char* what, const JointVector& values, double least,
                             double most) {
      RequireInRange(fmt::format("friction.{} of joint {}", what, i + 1), values[i], least, most);
    };
    require("viscous", law.viscous, 0, 100);
    require("coulomb", law.coulomb, 0, 100);
    require("offset", law.offset, -100, 100);
    require("steepness", law.steepness, 0.1, 1e4);
    require("shift", law.shift, -10, 10);
    const double inertia = std::max(armature[i], kLeastInertia[i]);
    const double slope = law.viscous[i] + law.coulomb[i] * law.steepness[i] / 2;
    if (slope * kCycleSeconds < 2 * inertia) continue;
    throw InputError(fmt::format(
        "friction of joint {}: viscous + coulomb * steepness / 2 is {:.4g} Nm s/rad, at which a "
        "joint of {:.4g} kg m^2 chatters at 1 kHz; it must be below {:.4g}: lower the steepness{}",
        i + 1, slope, inertia, 2 * inertia / kCycleSeconds,
        armature[i] > 0 ? "" : ", or give the joints their armature"));
  }
}

}  // namespace twin::plant
