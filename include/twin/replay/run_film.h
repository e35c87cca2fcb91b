#pragma once

#include <span>

#include "twin/record/log_records.h"
#include "twin/render/film.h"
#include "twin/scenario/scenario.h"

struct mjModel_;

namespace twin::replay {

/// All that is known of a run and can be drawn of it, whether it has just ended or comes out of a
/// log: the same of both, so that its video can be made again.
///
///   title  the scenario's name, and under it the controller's gains, or the application's type
///   goals  the plans
///   notes  plans as they begin, by their captions; of the events those that people look for:
///   steps,
///          the hand, errors, stops, recoveries. One line of at most 48 characters each, ASCII.
///
/// Threads: any. @param model, snapshots  must outlive the film.
[[nodiscard]] render::Film FilmOfRun(const mjModel_& model, const render::Snapshots& snapshots,
                                     const scenario::Scenario& scenario,
                                     std::span<const record::PlanRecord> plans,
                                     std::span<const record::EventRecord> events);

}  // namespace twin::replay
