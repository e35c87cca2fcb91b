#include "twin/rt/child_process.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "twin/core/clock.h"
#include "twin/rt/host_time.h"

namespace twin::rt {
namespace {

/// Poll period for its end.
constexpr std::chrono::milliseconds kLook(2);

/// Read by waiting threads, written once per command; needs no ordering.
std::atomic<const volatile bool*> gives_up_when{nullptr};

/// Start attributes of the child.
class SpawnSettings {
 public:
  explicit SpawnSettings(const ChildProcess::Files& files) {
    posix_spawn_file_actions_init(&actions_);
    Give(files.in, STDIN_FILENO, O_RDONLY);
    Give(files.out, STDOUT_FILENO, O_WRONLY);
    Give(files.error, STDERR_FILENO, O_WRONLY);
    if (files.kept_open >= 0) {
      posix_spawn_file_actions_adddup2(&actions_, files.kept_open, STDERR_FILENO + 1);
    }
    sigset_t none;
    sigemptyset(&none);
    sigset_t all;
    sigfillset(&all);
    posix_spawnattr_init(&attributes_);
    posix_spawnattr_setpgroup(&attributes_, 0);
    posix_spawnattr_setsigmask(&attributes_, &none);
    posix_spawnattr_setsigdefault(&attributes_, &all);
    posix_spawnattr_setflags(
        &attributes_, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
  }
  ~SpawnSettings() {
    posix_spawnattr_destroy(&attributes_);
    posix_spawn_file_actions_destroy(&actions_);
  }
  SpawnSettings(const SpawnSettings&) = delete;
  SpawnSettings& operator=(const SpawnSettings&) = delete;

  [[nodiscard]] const posix_spawn_file_actions_t* actions() const noexcept { return &actions_; }
  [[nodiscard]] const posix_spawnattr_t* attributes() const noexcept { return &attributes_; }

 private:
  void Give(int descriptor, int as, int mode) {
    if (descriptor >= 0) {
      posix_spawn_file_actions_adddup2(&actions_, descriptor, as);
    } else {
      posix_spawn_file_actions_addopen(&actions_, as, "/dev/null", mode, 0);
    }
  }

  posix_spawn_file_actions_t actions_;
  posix_spawnattr_t attributes_;
};

}  // namespace

ChildProcess::ChildProcess(const std::string& program, const std::vector<std::string>& arguments,
                           const Files& files) {
  const SpawnSettings settings(files);
  std::vector<std::string> words{program};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  argv.reserve(words.size() + 1);
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  const int error = posix_spawnp(&pid_, program.c_str(), settings.actions(), settings.attributes(),
                                 argv.data(), environ);
  if (error == 0) return;
  pid_ = -1;
  throw std::system_error(error, std::generic_category(), program);
}

std::optional<int> ChildProcess::Wait(Duration limit) {
  const MonotonicClock clock;
  while (pid_ >= 0) {
    int status = 0;
    const pid_t ended = ::waitpid(pid_, &status, WNOHANG);
    if (ended == pid_) {
      pid_ = -1;
      return status;
    }
    if (ended < 0 && errno != EINTR) break;
    if (GivesUp() || clock.Now().time_since_epoch() >= limit) break;
    Pause(kLook);
  }
  Kill();
  return std::nullopt;
}

std::optional<int> ChildProcess::Poll() noexcept {
  int status = 0;
  if (pid_ < 0 || ::waitpid(pid_, &status, WNOHANG) != pid_) return std::nullopt;
  pid_ = -1;
  return status;
}

void ChildProcess::Kill() noexcept {
  if (pid_ < 0) return;
  ::kill(-pid_, SIGKILL);
  while (::waitpid(pid_, nullptr, 0) < 0 && errno == EINTR) {
  }
  pid_ = -1;
}

void GiveUpWhen(const volatile bool* interrupted) noexcept {
  gives_up_when.store(interrupted, std::memory_order_relaxed);
}

bool GivesUp() noexcept {
  const volatile bool* const interrupted = gives_up_when.load(std::memory_order_relaxed);
  return interrupted != nullptr && *interrupted;
}

std::string DescribeEnd(int status) {
  if (WIFSIGNALED(status)) {
    return fmt::format("was ended by signal {} ({})", WTERMSIG(status),
                       strsignal(WTERMSIG(status)));
  }
  return fmt::format("ended with exit code {}", WEXITSTATUS(status));
}

}  // namespace twin::rt
