#pragma once

#include "twin/core/joint_vector.h"
#include "twin/core/realtime.h"

namespace twin::plant {

/// A friction of the joints that a scenario or a robot's profile describes:
///   tau_f(dq) = viscous dq + coulomb [2 / (1 + exp(-steepness (dq + shift)))
///                                     - 2 / (1 + exp(-steepness shift))] + offset,
/// opposed to the motion. 2 coulomb is the height of the sigmoid of Gaz et al. 2019 (phi1),
/// steepness and shift are its phi2 and phi3; with a large steepness the law is viscous + Coulomb
/// friction + offset. The offset acts at rest, too.
///
/// The plant applies it explicitly, from dq at the beginning of a step of T = 1 ms. With slope =
/// viscous + coulomb steepness / 2, the steepest of the law, the friction stays stable up to
///   slope T < 2 B,
/// B the joint's inertia; beyond, the joint chatters at rest. With the rotors B >= 0.2 kg m^2: a
/// Coulomb friction of 0.4 Nm takes any steepness below 2000 s/rad. Without them the least B of
/// joints 5 to 7 of the bare arm is 0.012, 0.016 and 0.004 kg m^2 (kLeastInertia): 0.2 Nm take a
/// steepness below 230, 310 and 74 s/rad. Validate() refuses more. Without rotors it looks at each
/// joint alone, so that joints near their bounds may chatter together; half the bound is safe.
struct FrictionLaw {
  JointVector viscous{};                                     ///< Nm s/rad, in [0, 100]
  JointVector coulomb{};                                     ///< Nm, in [0, 100]
  JointVector offset{};                                      ///< Nm, in [-100, 100]
  JointVector steepness{100, 100, 100, 100, 100, 100, 100};  ///< s/rad, in [0.1, 10000]
  JointVector shift{};                                       ///< rad/s, in [-10, 10]
  bool operator==(const FrictionLaw&) const = default;
};

/// Threads: any (stateless). Real-time: noexcept, allocates nothing.
/// @param dq  rad/s. @returns the torque that opposes the motion, Nm.
[[nodiscard]] JointVector Friction(const FrictionLaw& law,
                                   const JointVector& dq) noexcept TWIN_REALTIME;

/// @param armature  inertia of the rotors seen at the link, kg m^2; zero: none.
/// @throws InputError naming coefficient, joint and range: out of range, or unstable at 1 kHz.
void Validate(const FrictionLaw& law, const JointVector& armature);

}  // namespace twin::plant
