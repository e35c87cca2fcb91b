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

/// Least inertia that a joint without rotor shows while the others are free, 1 / (M^-1)_ii over the
/// joint range of the bare arm, kg m^2: the least of 40,000 poses drawn from it, with the masses of
/// the URDF. Links of another mass scale it, which the bound on friction ignores.
inline constexpr JointVector kLeastInertia{0.041, 0.39, 0.0185, 0.097, 0.0117, 0.0159, 0.0037};

}  // namespace twin::plant
