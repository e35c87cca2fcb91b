#include "twin/server/bell.h"

#include <sys/eventfd.h>

#include "twin/core/error.h"

namespace twin::server {

Bell::Bell() : fd_(eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {
  if (fd_.valid()) return;
  throw EnvironmentError(
      "no file descriptor is left to wait with; raise the limit of open files (`ulimit -n`)");
}

void Bell::Ring() noexcept {
  // It fails when it has been rung 2^64 - 1 times already, and then it rings.
  static_cast<void>(eventfd_write(fd_.get(), 1));
}

bool Bell::Silence() noexcept {
  eventfd_t rung = 0;
  return eventfd_read(fd_.get(), &rung) == 0;
}

}  // namespace twin::server
