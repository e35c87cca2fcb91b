#pragma once

#include <span>

#include "twin/record/log_records.h"
#include "twin/render/film.h"
#include "twin/scenario/scenario.h"

struct mjModel_;

namespace twin::replay {

/// All drawable data of a run, from its end or from a log. Both give the same, so that a video can
/// be made again.
///
///   title  the scenario's name; below it the controller's gains or the application's type
///   goals  the plans
///   notes  the captions of starting plans, and the events that matter to users: steps, the hand,
///          errors, stops, recoveries. One line of at most 48 characters each, ASCII.
///
/// Threads: any. @param model, snapshots  must outlive the film.
[[nodiscard]] render::Film FilmOfRun(const mjModel_& model, const render::Snapshots& snapshots,
                                     const scenario::Scenario& scenario,
                                     std::span<const record::PlanRecord> plans,
                                     std::span<const record::EventRecord> events);

}  // namespace twin::replay
