#include "twin/golden/goldens_lock.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

#include "twin/core/error.h"

namespace twin::golden {

GoldensLock::GoldensLock(const std::filesystem::path& goldens)
    : descriptor_(::open(goldens.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
  if (descriptor_ < 0) {
    throw EnvironmentError(fmt::format("{}: cannot be opened ({})", goldens.string(),
                                       std::generic_category().message(errno)));
  }
  if (::flock(descriptor_, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK) return;
  ::close(descriptor_);
  throw EnvironmentError(fmt::format(
      "another approval writes into {}; wait for it, and approve then", goldens.string()));
}

GoldensLock::~GoldensLock() {
  ::close(descriptor_);
}

}  // namespace twin::golden
