#pragma once

#include "twin/core/realtime.h"
#include "twin/core/time.h"

namespace twin::rt {

/// Where one thread waits until something may have arrived: a state from another thread, a packet
/// at a socket. The only thing the communication thread ever waits for.
///
/// Threads: one waits. Real-time: bounded by the deadline; allocates nothing, takes no lock.
class Arrival {
 public:
  virtual ~Arrival() = default;

  /// Returns when something has arrived that no earlier call has told of, or at `deadline`.
  /// @returns whether something has.
  [[nodiscard]] virtual bool AwaitUntil(Time deadline) noexcept TWIN_REALTIME = 0;
};

}  // namespace twin::rt
