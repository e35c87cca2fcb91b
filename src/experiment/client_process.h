#pragma once

#include <string>

#include <sys/types.h>

namespace twin::experiment {

/// A shell's command line run beside this process, with its standard files, as a group of its own:
/// when this process reads from a terminal the group has that for as long, so that Ctrl-C there
/// ends the client.
///
/// Threads: one.
class ClientProcess {
 public:
  /// @throws EnvironmentError when no shell can be started.
  explicit ClientProcess(const std::string& command);
  /// As End().
  ~ClientProcess();
  ClientProcess(const ClientProcess&) = delete;
  ClientProcess& operator=(const ClientProcess&) = delete;

  /// Whether it has ended by now.
  [[nodiscard]] bool HasEnded();
  /// Asks it and all it has started to end, and makes them after a second. Nothing when it has.
  void End();
  /// How, for people: "exit code 1", "signal 6". @pre it has.
  [[nodiscard]] std::string HowItEnded() const;

 private:
  /// The terminal's foreground is that group from now on.
  static void GiveTerminalTo(pid_t group);

  pid_t process_ = 0;
  bool has_ended_ = false;
  int status_ = 0;
};

}  // namespace twin::experiment
