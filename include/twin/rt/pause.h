#pragma once

#include "twin/core/time.h"

namespace twin::rt {

/// Lets the calling thread sleep for about `duration` of the host's time. For helper threads off
/// the control path only (the log's writer): nothing whose outcome a run repeats may depend on it.
void Pause(Duration duration);

}  // namespace twin::rt
