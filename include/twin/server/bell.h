#pragma once

#include "twin/core/realtime.h"
#include "twin/fci/sockets.h"

namespace twin::server {

/// Wakes a thread that waits for descriptors: one of them is the bell's (Linux: eventfd).
///
/// Threads: Ring() from any, the rest from the one that waits. Real-time: Ring() is noexcept, never
/// waits, allocates nothing; it is a system call.
class Bell {
 public:
  /// @throws EnvironmentError when the system has no descriptor left.
  Bell();

  void Ring() noexcept TWIN_REALTIME;
  /// Readable once it has been rung.
  [[nodiscard]] int fd() const noexcept { return fd_.get(); }
  /// @returns whether it was rung since the last call.
  [[nodiscard]] bool Silence() noexcept;

 private:
  fci::FileDescriptor fd_;
};

}  // namespace twin::server
