#pragma once

#include <cstdint>

#include "campaign/trial.h"

namespace twin::campaign {

/// Clients of a served robot that ask for anything at any time, held against the rules of a session
/// (README.md, invariant `session`): drawn requests, good and bad, in pieces or many at once, in
/// every mode; motions with drawn ends; junk on both sockets; second clients; connections that end
/// anywhere. A Panda or an FR3; loopback sockets; the robot in lockstep.
///
/// Threads: any.
[[nodiscard]] Outcome RunSessionWorld(std::uint64_t seed, const run::RunFiles& files);

}  // namespace twin::campaign
