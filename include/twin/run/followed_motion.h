#pragma once

#include <limits>
#include <string>

#include "twin/control/controller.h"
#include "twin/core/modes.h"
#include "twin/core/time.h"
#include "twin/loop/deviation.h"
#include "twin/scenario/scenario.h"

namespace twin::run {

/// The same of one motion; infinite where it is not judged.
struct DeviationLimit {
  double joints = std::numeric_limits<double>::infinity();    ///< rad
  double position = std::numeric_limits<double>::infinity();  ///< m
  double angle = std::numeric_limits<double>::infinity();     ///< rad
};

/// What a motion came to that the robot's own controller should have kept on its path.
struct FollowedMotion {
  std::string name;  ///< empty: the only one
  Time begun{};      ///< of the session
  loop::Deviation deviation;
  DeviationLimit limit;
  bool succeeded = false;  ///< else its failure tells more than its deviation

  [[nodiscard]] bool exceeds() const noexcept { return succeeded && !Excess().empty(); }
  /// By what it is above its limit, for people; empty: by nothing.
  [[nodiscard]] std::string Excess() const;
};

/// What the scenario says of a motion on this interface, which the robot follows by `impedance`.
/// What it does not say is 20 mrad, or 20 mm and 20 mrad of poses, times as often as the robot is
/// softer (onboard.K_theta, onboard.K_x) than as delivered: what friction, inertia and loads take
/// from its path is a force over its stiffness. Not judged unless it is said: torques, which are as
/// stiff as their controller, and a scenario with perturbations, which are there to move the arm
/// off its path.
[[nodiscard]] DeviationLimit LimitOf(const scenario::Scenario& scenario,
                                     control::CommandInterface interface, ControllerMode impedance);

}  // namespace twin::run
