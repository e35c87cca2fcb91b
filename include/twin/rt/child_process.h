#pragma once

#include <sys/types.h>

#include <optional>
#include <string>
#include <vector>

#include "twin/core/time.h"

namespace twin::rt {

/// A program that this one starts and waits for, in a process group of its own, with default
/// signals. It never outlives this object: what has not ended by then is killed, and what it
/// started in its group with it.
///
/// Threads: one thread. Real-time: no.
class ChildProcess {
 public:
  /// Descriptors that become its standard files; -1: /dev/null.
  struct Files {
    int in = -1;
    int out = -1;
    int error = -1;
    int kept_open = -1;  ///< inherited beside them, as number 3; -1: none
  };

  /// @param program  looked up in PATH unless it has a slash. @param arguments  without its name.
  /// @throws std::system_error when it cannot be started.
  ChildProcess(const std::string& program, const std::vector<std::string>& arguments,
               const Files& files);
  ~ChildProcess() { Kill(); }
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  /// Waits until it has ended.
  /// @returns its wait status; nothing when `limit` came first or the user wants to end
  /// (GiveUpWhen): it is then killed.
  [[nodiscard]] std::optional<int> Wait(Duration limit);

  /// Ends it and its group at once, if it has not ended.
  void Kill() noexcept;

 private:
  pid_t pid_ = -1;  ///< -1: it has ended
};

/// What ends every wait for a child, and for what one takes in, as soon as it is true; null:
/// nothing does. It is set by a signal handler, and like those it is the whole process's. Must live
/// until it is replaced.
void GiveUpWhen(const volatile bool* interrupted) noexcept;

/// Whether that has come.
[[nodiscard]] bool GivesUp() noexcept;

/// "was ended by signal 9 (Killed)", "ended with exit code 1". @param status  of a wait.
[[nodiscard]] std::string DescribeEnd(int status);

}  // namespace twin::rt
