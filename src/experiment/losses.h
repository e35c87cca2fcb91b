#pragma once

#include "twin/experiment/experiment.h"

namespace twin::experiment {

/// What runs of lost commands do to a motion, behind each way of making its commands: a stream of
/// the planned positions, the paper's reference generator, the client library's rate limiter, and
/// the rejoining generator with the viability filter. Share of motions that the robot aborts
/// against the length of the runs, their rate, and the share of single losses, and how far those
/// that are completed are off the plan.
[[nodiscard]] Findings RunLosses(const Setting& setting);

}  // namespace twin::experiment
