#pragma once

#include <array>
#include <cmath>
#include <optional>

#include "twin/core/joint_vector.h"
#include "twin/core/realtime.h"
#include "twin/core/setting.h"
#include "twin/core/time.h"

namespace twin::plant {

/// Friction of each joint by a sigmoid of its velocity, opposed to the motion, zero at rest but for
/// the offset:
///   tau_f(dq) = viscous dq + coulomb (s(dq + shift) - s(shift)) + offset,
///   s(v) = 2 / (1 + exp(-steepness v)).
/// A large steepness gives viscous and Coulomb friction and an offset; Gaz's sigmoid (see
/// model::ResidualFriction) is coulomb = phi1 / 2, steepness = phi2, shift = phi3.
///
/// Threads: any (immutable). Real-time: Torque() allocates nothing.
struct FrictionLaw {
  JointVector viscous{};                                     ///< Nms/rad, >= 0
  JointVector coulomb{};                                     ///< Nm, >= 0
  JointVector offset{};                                      ///< Nm
  JointVector steepness{100, 100, 100, 100, 100, 100, 100};  ///< s/rad, > 0
  JointVector shift{};                                       ///< rad/s

  /// @param dq  7, joint order, rad/s. @returns Nm.
  [[nodiscard]] JointVector Torque(const JointVector& dq) const noexcept TWIN_REALTIME {
    JointVector tau;
    for (std::size_t i = 0; i < kJoints; ++i) {
      // 2 / (1 + exp(-x)) = 1 + tanh(x / 2)
      const double step = std::tanh(0.5 * steepness[i] * (dq[i] + shift[i])) -
                          std::tanh(0.5 * steepness[i] * shift[i]);
      tau[i] = viscous[i] * dq[i] + coulomb[i] * step + offset[i];
    }
    return tau;
  }

  bool operator==(const FrictionLaw&) const = default;
};

/// Longest delay of the torque sensors.
inline constexpr Duration kLongestTorqueDelay = 20 * kCycle;

/// Figures of one arm, identified on it; each absent one is the model's own.
struct JointFigures {
  std::optional<FrictionLaw> friction{};   ///< in place of a FrictionProfile
  std::optional<JointVector> armature{};   ///< reflected inertia of the rotors, kg m^2, >= 0
  std::optional<JointVector> stiffness{};  ///< of gear and torque sensor, Nm/rad, > 0
  Duration tau_J_delay{};                  ///< of the torque sensors, [0, kLongestTorqueDelay]
  /// Links in place of the URDF's: mass, centre in the joint's frame, inertia about the centre.
  std::optional<std::array<setting::Load, kJoints>> links{};

  bool operator==(const JointFigures&) const = default;
};

}  // namespace twin::plant
