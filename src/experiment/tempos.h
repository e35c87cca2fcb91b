#pragma once

#include <array>
#include <string_view>

#include "twin/experiment/experiment.h"
#include "twin/scenario/loss.h"
#include "twin/scenario/scenario.h"

namespace twin::experiment {

/// How fast a motion goes, as shares of the limits of acceleration and speed.
struct Tempo {
  std::string_view name;
  double stretch = 0;  ///< of the brisk trajectory's time; 0: it is the canonical one
};

/// Canonical: 0.1 of the acceleration limits; brisk: 0.6, and 0.8 of the speed limits; hard: 0.85
/// and 0.95.
inline constexpr std::array<Tempo, 3> kTempos{{{"canonical", 0}, {"brisk", 1}, {"hard", 0.84}}};

/// Has the scenario move along its own, canonical trajectory, or along the brisk one, as joint
/// positions. @throws InputError as scenario::Load.
void SetTempo(const Setting& setting, const Tempo& tempo, scenario::Scenario& scenario);

/// Runs of lost messages.
struct Bursts {
  int length = 0;         ///< messages in a row
  double per_second = 2;  ///< so many begin in the mean
};

/// The same at random instants, which depend on run and `per_second` and on nothing else.
/// @param seconds  how long the motion takes.
[[nodiscard]] scenario::Loss LossOf(const Setting& setting, const Bursts& bursts, double seconds,
                                    int run);

}  // namespace twin::experiment
