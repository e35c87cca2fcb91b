#pragma once

#include <optional>

#include "twin/fci/sockets.h"
#include "twin/run/run.h"
#include "twin/scenario/scenario.h"

// A process that serves a robot and moves it too: as an ordinary client, by backend fci, so that
// the whole command chain stands before the robot and the server refuses a second client.
namespace twin::application {

/// The served robot's scenario for such a client: no motion, hand command, mobile base or
/// controller.
[[nodiscard]] scenario::Scenario OwnClientOf(const scenario::Scenario& served);

/// Where it connects. @param arm, hand  where they are served.
[[nodiscard]] run::RealtimeConfig OwnClientAt(const fci::Endpoint& arm,
                                              const std::optional<fci::Endpoint>& hand);

}  // namespace twin::application
