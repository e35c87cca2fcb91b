#pragma once

#include <sys/types.h>
#include <unistd.h>

#include <stdexcept>
#include <string>

namespace twin::python {

/// The process that made an object with threads: they do not live on in a fork of it.
class HomeProcess {
 public:
  [[nodiscard]] bool is_elsewhere() const noexcept { return ::getpid() != id_; }
  /// @throws std::runtime_error in a fork.
  void Require(const std::string& what) const {
    if (!is_elsewhere()) return;
    throw std::runtime_error(what + " is process " + std::to_string(id_) +
                             "'s, and its threads do not live on in a fork: make one here");
  }

 private:
  pid_t id_ = ::getpid();
};

}  // namespace twin::python
