#pragma once

#include "twin/core/realtime.h"
#include "twin/core/time.h"
#include "twin/plant/truth_probe.h"
#include "twin/rt/scene_record.h"

namespace twin::plant {

/// Takes down where everything is and what presses on what: contacts that bear a force, in the
/// engine's order, and pushes on bodies, each drawn as one force where its moment about the body's
/// centre of mass puts it (a torque alone is none).
///
/// Threads: the plant's. Real-time: noexcept, O(contacts + bodies), allocates nothing.
/// @pre truth.qpos_size() <= rt::SceneRecord::kMostPositions.
void CaptureScene(Time now, const TruthProbe& truth, rt::SceneRecord& scene) noexcept TWIN_REALTIME;

}  // namespace twin::plant
