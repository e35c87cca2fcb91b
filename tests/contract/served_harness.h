#pragma once

#include <memory>

#include "contract/backend_harness.h"
#include "twin/backend/registry.h"

namespace twin::test {

/// The backend "fci" against this project's own server, in one process, over loopback.
/// @param time  kStates: served in lockstep; kWall: in real time.
[[nodiscard]] std::unique_ptr<BackendHarness> MakeServedHarness(const robot::RobotConfig& robot,
                                                                backend::RobotTime time);

}  // namespace twin::test
