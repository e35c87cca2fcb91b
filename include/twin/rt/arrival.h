#pragma once

#include "twin/core/realtime.h"
#include "twin/core/time.h"

namespace twin::rt {

/// Lets one thread wait for data: a state from another thread, or a packet at a socket. The
/// communication thread waits nowhere else.
///
/// Threads: one waits. Real-time: bounded by the deadline; allocates nothing, takes no lock.
class Arrival {
 public:
  virtual ~Arrival() = default;

  /// Waits until something arrives that no earlier call has reported, or until `deadline`.
  /// @returns whether something has arrived.
  [[nodiscard]] virtual bool AwaitUntil(Time deadline) noexcept TWIN_REALTIME = 0;
};

}  // namespace twin::rt
