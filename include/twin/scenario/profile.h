#pragma once

#include <filesystem>
#include <limits>
#include <optional>
#include <string>

#include "twin/core/joint_vector.h"

namespace twin::scenario {

/// What a robot's profile says beside its keys of a scenario. A profile is what was identified of
/// one robot, a YAML file:
///     profile: 1                       # version of the format
///     robot: panda                     # robot.model
///     identified: {...}                # when, by whom, from which log; for people
///     holds_for: {speed: {unit: rad/s, values: [...]}, load: {from: 0 kg, to: 1.2 kg}}
///     scenario: {plant: {...}, link: {...}, robot: {load: {...}}}    # these sections alone
///     covariance: {keys: [plant.friction.viscous[0], ...], matrix: [[...], ...]}
/// A scenario that names it takes those keys where it says nothing itself; its robot.load counts
/// as one. Scenarios that are written hold the keys, and not the profile's name.
///
/// robot.profile_draw n, above 0, moves the numbers that `covariance` names (indices from 0, SI
/// units) by the nth draw of a normal distribution with that matrix: it depends on the profile and
/// n alone. What a key does not take is put to its nearest bound; a load or link that no body is
/// keeps the profile's inertia.
struct Profile {
  std::filesystem::path file;
  std::string hash;                  ///< ContentHash of the file
  std::optional<JointVector> speed;  ///< of `holds_for`: largest magnitudes, rad/s
  double least_load = 0;             ///< kg
  double most_load = std::numeric_limits<double>::infinity();

  /// @param speed  largest of a motion, rad/s. @param load  that the flange carries, kg.
  /// @returns a line for people if they lie outside what the profile holds for, by more than 1 %;
  /// else empty. Threads: any.
  [[nodiscard]] std::string Excess(const JointVector& speed, double load) const;
};

}  // namespace twin::scenario
