#include "experiment/client_process.h"

#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <system_error>

#include <fmt/format.h>

#include "twin/core/error.h"

namespace twin::experiment {

ClientProcess::ClientProcess(const std::string& command) {
  std::string shell = "/bin/sh";
  std::string option = "-c";
  std::string line = command;
  char* const arguments[] = {shell.data(), option.data(), line.data(), nullptr};
  // What this program ignores or catches, the client need not.
  posix_spawnattr_t attributes;
  ::posix_spawnattr_init(&attributes);
  sigset_t signals;
  ::sigemptyset(&signals);
  for (const int signal : {SIGPIPE, SIGINT, SIGTERM}) ::sigaddset(&signals, signal);
  ::posix_spawnattr_setsigdefault(&attributes, &signals);
  ::posix_spawnattr_setpgroup(&attributes, 0);
  ::posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP);
  const int failed =
      ::posix_spawn(&process_, shell.c_str(), nullptr, &attributes, arguments, environ);
  ::posix_spawnattr_destroy(&attributes);
  if (failed == 0) {
    GiveTerminalTo(process_);
    return;
  }
  throw EnvironmentError(fmt::format("cannot start /bin/sh for the client: {}",
                                     std::generic_category().message(failed)));
}

ClientProcess::~ClientProcess() {
  End();
}

void ClientProcess::GiveTerminalTo(pid_t group) {
  if (::isatty(STDIN_FILENO) == 0) return;
  // Who is not in the foreground any more would be stopped for asking to be.
  sigset_t output;
  sigset_t before;
  ::sigemptyset(&output);
  ::sigaddset(&output, SIGTTOU);
  ::pthread_sigmask(SIG_BLOCK, &output, &before);
  ::tcsetpgrp(STDIN_FILENO, group);
  ::pthread_sigmask(SIG_SETMASK, &before, nullptr);
}

void ClientProcess::End() {
  if (HasEnded()) return;
  constexpr int kLooks = 100;
  ::kill(-process_, SIGTERM);
  for (int look = 0; look < kLooks && !HasEnded(); ++look) ::usleep(10'000);
  ::kill(-process_, SIGKILL);
  while (!HasEnded()) ::usleep(1'000);
}

bool ClientProcess::HasEnded() {
  if (has_ended_) return true;
  has_ended_ = ::waitpid(process_, &status_, WNOHANG) == process_;
  if (has_ended_) GiveTerminalTo(::getpgrp());
  return has_ended_;
}

std::string ClientProcess::HowItEnded() const {
  if (WIFSIGNALED(status_)) return fmt::format("signal {}", WTERMSIG(status_));
  return fmt::format("exit code {}", WEXITSTATUS(status_));
}

}  // namespace twin::experiment
