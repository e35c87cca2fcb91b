#pragma once

#include "conformance/dice.h"
#include "twin/core/joint_vector.h"
#include "twin/scenario/scenario.h"

namespace twin::campaign {

/// Where all motions are near: the usual ready position, rad.
inline constexpr JointVector kReady{0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854};

/// Draws what most worlds do not have: properties of the arm, hands that lead it, settings and
/// controllers that are seldom changed, limits of a lab, a mobile base, a part to grasp.
/// @param all  false: only what surrounds robot, motion and controller.
void DrawRareThings(test::Dice& dice, scenario::Scenario& world, bool all);

}  // namespace twin::campaign
