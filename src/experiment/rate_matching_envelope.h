#pragma once

#include "twin/experiment/experiment.h"

namespace twin::experiment {

/// The canonical trajectory from a velocity source at 125 Hz, rate matching off and on, rate
/// limiter on in both: whether the commands' envelopes coincide over the motion, as in the paper's
/// figure. Adds comparisons and a figure.
/// @throws as RunScenario.
void AddEnvelopes(const Setting& setting, Findings& findings);

}  // namespace twin::experiment
