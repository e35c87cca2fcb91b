#pragma once

#include <memory>

#include "twin/application/application.h"
#include "twin/control/parameters.h"

namespace twin::application {

/// The paper's third: an object is taken from one surface and put, turned, on another, every way
/// through the joint position interface by damped least squares (type pick_and_place).
///
///   plan -> approach -> grasp -> lift -> transfer -> place -> release -> retreat
///
/// A grasp that holds nothing, or something of another width, is tried again: open, away, approach.
/// A way that the robot ended by an error is planned anew from where the arm stopped, once, as long
/// as the hand holds what it should. While it carries, the robot is told the object's mass.
[[nodiscard]] std::unique_ptr<Application> MakePickAndPlace(control::ParameterReader& parameters);

}  // namespace twin::application
