#pragma once

#include <memory>

#include "contract/backend_harness.h"
#include "twin/backend/registry.h"

namespace twin::test {

/// The backend "fci" against this project's own server, in one process, over loopback.
/// @param time  kStates: served in lockstep; kWall: in real time.
/// @param freeze  in lockstep: as robot::LockstepOptions::freeze_when_idle.
[[nodiscard]] std::unique_ptr<BackendHarness> MakeServedHarness(const robot::RobotConfig& robot,
                                                                backend::RobotTime time,
                                                                bool freeze = false);

}  // namespace twin::test
