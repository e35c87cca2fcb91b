#pragma once

#include <optional>
#include <vector>

#include "twin/core/joint_vector.h"
#include "twin/core/setting.h"
#include "twin/core/time.h"
#include "twin/plant/friction_law.h"

namespace twin::plant {

/// Inertia of the drives' rotors reflected to the link, kg m^2. Source: README of Drake's
/// franka_description, as provided by Franka for its FR3; no Panda values are published.
inline constexpr JointVector kArmature{0.605721456, 0.605721456, 0.462474144, 0.462474144,
                                       0.205544064, 0.205544064, 0.205544064};

/// Stiffness of gear and torque sensor, Nm/rad. The Panda's is not public. Decision: the largest
/// K_theta that the robot accepts (FCI protocol 5), since motor-side control cannot make the link
/// stiffer than the transmission. The largest load, 60 Nm at joint 2, then deflects it by 4 mrad.
inline constexpr JointVector kJointStiffness{14250, 14250, 14250, 14250, 14250, 14250, 14250};

/// Longest delay of the torque sensors.
inline constexpr Duration kLongestTorqueDelay = 20 * kCycle;

/// What is known of one arm, and not of its kind; by default nothing.
struct ArmProperties {
  std::optional<FrictionLaw> friction_law;  ///< absent: that of the profile
  std::optional<JointVector> armature;      ///< kg m^2, in [0, 10]; absent: kArmature
  /// Under ElasticityProfile::kStatic, Nm/rad, in [1, 1e7].
  JointVector stiffness = kJointStiffness;
  /// By how much sensors().tau_J is late, with linear interpolation between cycles; in [0,
  /// kLongestTorqueDelay].
  Duration torque_delay{};
  /// Links 1 to 7 in place of the URDF's: mass, centre of mass in the link's frame (the joint's),
  /// inertia about it along the frame's axes. Seven, positive definite, or none.
  std::vector<setting::Load> links;
  bool operator==(const ArmProperties&) const = default;
};

/// @returns the inertia of the rotors seen at the link, kg m^2; zero without armature. Threads:
/// any.
[[nodiscard]] JointVector RotorInertia(bool has_armature, const ArmProperties& arm);

/// Threads: any. @throws InputError naming property, joint and range.
void Validate(const ArmProperties& arm, bool has_armature);

}  // namespace twin::plant
