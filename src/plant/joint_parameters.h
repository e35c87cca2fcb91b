#pragma once

#include "twin/core/joint_vector.h"
#include "twin/model/arm_model.h"

namespace twin::plant {

/// The friction of FrictionProfile::kResidual.
using model::ResidualFriction;

/// Break-away torque of a joint at rest, Nm. Measured through the FCI on one Panda by a ramp of
/// external torque up to 0.5 deg of motion, so an upper estimate. Source: franka_emulator (RWTH,
/// MIT licence), model.urdf of 2021-11-20.
inline constexpr JointVector kBreakawayTorque{0.8315,  0.99845, 0.8923, 1.29255,
                                              0.81225, 0.58725, 0.4132};

/// Viscous friction to add, Nm s/rad. Source: Gaz et al. 2019, supplementary table III, row "OSI"
/// (the row with a positive value for joint 6).
inline constexpr JointVector kViscousFriction{0.0628, 0.2088,    0.0361, 0.2174,
                                              0.1021, 1.6128e-4, 0.0632};

/// Inertia of the drives' rotors reflected to the link, kg m^2. Source: README of Drake's
/// franka_description, as provided by Franka for its FR3; no Panda values are published.
inline constexpr JointVector kArmature{0.605721456, 0.605721456, 0.462474144, 0.462474144,
                                       0.205544064, 0.205544064, 0.205544064};

/// Stiffness of gear and torque sensor in ElasticityProfile::kStatic, all joints, Nm/rad. The
/// Panda's is not public. Decision: the largest K_theta that the robot accepts (FCI protocol 5),
/// since motor-side control cannot make the link stiffer than the transmission. The largest load,
/// 60 Nm at joint 2, then deflects it by 4 mrad.
inline constexpr double kJointStiffness = 14250;

}  // namespace twin::plant
