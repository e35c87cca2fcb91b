#pragma once

#include "twin/experiment/experiment.h"
#include "twin/rt/cycle_record.h"
#include "twin/run/run.h"
#include "twin/scenario/scenario.h"

namespace twin::experiment {

/// Runs a scenario's loop on the wall clock, over UDP on this machine, against a robot of its own
/// that is served as `panda-twin serve` does it. Plant, sensors and start are the scenario's;
/// delays and costs are what passes. One host has one clock: the controller's drift is made by the
/// robot's, which runs slower by as much.
/// @param scenario  backend fci. @param sink  cycles come from the robot's thread, ticks from the
/// communication's; may be null.
/// @returns counts as the robot had them, not as the workstation guesses. @throws as RunScenario.
[[nodiscard]] run::RunResult RunOverWire(const Setting& setting, const scenario::Scenario& scenario,
                                         rt::RecordSink* sink);

}  // namespace twin::experiment
