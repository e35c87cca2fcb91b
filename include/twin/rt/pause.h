#pragma once

#include "twin/core/time.h"

namespace twin::rt {

/// Suspends the calling thread for about `duration` of host time. Only for helper threads off the
/// control path (the log's writer): nothing that a run must repeat may depend on it.
void Pause(Duration duration);

}  // namespace twin::rt
