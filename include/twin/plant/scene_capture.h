#pragma once

#include "twin/core/realtime.h"
#include "twin/core/time.h"
#include "twin/plant/truth_probe.h"
#include "twin/rt/scene_record.h"

namespace twin::plant {

/// Captures poses and forces: contacts with a force, in the engine's order, and pushes on bodies,
/// each as one force on the line that gives its moment about the body's centre of mass (a pure
/// torque is omitted).
///
/// Threads: the plant's. Real-time: noexcept, O(contacts + bodies), allocates nothing.
/// @pre truth.qpos_size() <= rt::SceneRecord::kMostPositions.
void CaptureScene(Time now, const TruthProbe& truth, rt::SceneRecord& scene) noexcept TWIN_REALTIME;

}  // namespace twin::plant
