#pragma once

#include "twin/core/realtime.h"
#include "twin/fci/sockets.h"

namespace twin::server {

/// Wakes a thread that polls the event's descriptor among others (Linux: eventfd).
///
/// Threads: Notify() from any, the rest from the polling thread. Real-time: Notify() is noexcept,
/// never waits and does not allocate; it is a system call.
class WakeEvent {
 public:
  /// @throws EnvironmentError if no descriptor is left.
  WakeEvent();

  void Notify() noexcept TWIN_REALTIME;
  /// Readable after Notify().
  [[nodiscard]] int fd() const noexcept { return fd_.get(); }
  /// @returns true if Notify() was called since the last Clear().
  [[nodiscard]] bool Clear() noexcept;

 private:
  fci::FileDescriptor fd_;
};

}  // namespace twin::server
