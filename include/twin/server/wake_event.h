#pragma once

#include "twin/core/realtime.h"
#include "twin/fci/sockets.h"

namespace twin::server {

/// Wakes a thread that polls descriptors, one of which is the event's (Linux: eventfd).
///
/// Threads: Notify() from any, the rest from the one that waits. Real-time: Notify() is noexcept,
/// never waits, allocates nothing; it is a system call.
class WakeEvent {
 public:
  /// @throws EnvironmentError when the system has no descriptor left.
  WakeEvent();

  void Notify() noexcept TWIN_REALTIME;
  /// Readable after Notify().
  [[nodiscard]] int fd() const noexcept { return fd_.get(); }
  /// @returns whether Notify() was called since the last Clear().
  [[nodiscard]] bool Clear() noexcept;

 private:
  fci::FileDescriptor fd_;
};

}  // namespace twin::server
