#pragma once

#include <sys/types.h>

#include <optional>
#include <string>
#include <vector>

#include "twin/core/time.h"

namespace twin::rt {

/// A child process in its own process group with default signals. It never outlives this object:
/// the destructor kills it and its group if it still runs.
///
/// Threads: one thread. Real-time: no.
class ChildProcess {
 public:
  /// Descriptors that become its standard files; -1: /dev/null.
  struct Files {
    int in = -1;
    int out = -1;
    int error = -1;
    int kept_open = -1;  ///< inherited as number 3; -1: none
  };

  /// @param program  looked up in PATH unless it has a slash. @param arguments  without its name.
  /// @throws std::system_error when it cannot be started.
  ChildProcess(const std::string& program, const std::vector<std::string>& arguments,
               const Files& files);
  ~ChildProcess() { Kill(); }
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  /// Waits for its end.
  /// @returns its wait status; nullopt after `limit` or an interrupt (GiveUpWhen), either of which
  /// kills it.
  [[nodiscard]] std::optional<int> Wait(Duration limit);

  /// Its wait status, once, when it has ended; nullopt while it runs.
  [[nodiscard]] std::optional<int> Poll() noexcept;

  /// Kills it and its group, if it still runs.
  void Kill() noexcept;

  /// Its process and group; -1: it has ended.
  [[nodiscard]] pid_t pid() const noexcept { return pid_; }

 private:
  pid_t pid_ = -1;  ///< -1: has ended
};

/// Sets the flag that ends all waits for a child and for its output as soon as it is true; null:
/// none. A signal handler sets the flag; like a handler it applies to the whole process. The flag
/// must live until it is replaced.
void GiveUpWhen(const volatile bool* interrupted) noexcept;

/// Whether the flag is set.
[[nodiscard]] bool GivesUp() noexcept;

/// "was ended by signal 9 (Killed)", "ended with exit code 1". @param status  of a wait.
[[nodiscard]] std::string DescribeEnd(int status);

}  // namespace twin::rt
