#pragma once

#include <string>

#include "application/pick_plan.h"
#include "twin/control/parameters.h"
#include "twin/scenario/frame_pose.h"
#include "twin/scenario/scenario.h"

namespace twin::application {

/// The parameters of pick and place; in brackets their keys.
struct PickParameters {
  /// @throws InputError naming file, line and key.
  explicit PickParameters(control::ParameterReader& parameters);

  std::string object;  ///< of the scenario's objects [object]
  std::string on;      ///< one of them, where it is put [place.on]
  /// There: as an object's position and rpy [place.position, place.rpy].
  scenario::FramePose place;
  scenario::FramePose spread;  ///< half widths of uniform ranges of these [place.spread]
  double force = 0;            ///< of each finger, N [grasp.force]
  double speed = 0;            ///< at which the hand closes, m/s [grasp.speed]
  double tolerance = 0;        ///< of the width at which the object is held, m [grasp.tolerance]
  int tries = 0;               ///< grasps, in all [grasp.tries]
  PickOptions options;
  std::string object_key;  ///< "<file>:<line>: application.parameters.object: "
  std::string on_key;      ///< the same of place.on
};

/// What the scenario's seed makes of it.
/// @throws InputError when the scenario has no such objects, naming those it has; or when the
/// object is fixed, or a ball, which does not stay.
[[nodiscard]] PickTask TaskOf(const scenario::Scenario& scenario, const PickParameters& parameters);

/// The mass as the scenario has it, without what it is spread by: what people know of it, kg.
[[nodiscard]] double NominalMass(const scenario::Scenario& scenario, const std::string& object);

}  // namespace twin::application
