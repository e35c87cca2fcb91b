#include "twin/server/wake_event.h"

#include <sys/eventfd.h>

#include "twin/core/error.h"

namespace twin::server {

WakeEvent::WakeEvent() : fd_(eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {
  if (fd_.valid()) return;
  throw EnvironmentError(
      "no file descriptor is left to wait with; raise the limit of open files (`ulimit -n`)");
}

void WakeEvent::Notify() noexcept {
  // It fails only when 2^64 - 1 notifications are pending; the reader then wakes anyway.
  static_cast<void>(eventfd_write(fd_.get(), 1));
}

bool WakeEvent::Clear() noexcept {
  eventfd_t count = 0;
  return eventfd_read(fd_.get(), &count) == 0;
}

}  // namespace twin::server
