#include "report/gnuplot.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <string>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "twin/core/error.h"

namespace twin::report {
namespace {

std::string Message(int error) {
  return std::generic_category().message(error);
}

/// An open file.
class Descriptor {
 public:
  /// @param number  what open() returned; taken over.
  Descriptor(int number, const std::string& name) : number_(number) {
    if (number_ < 0) {
      throw EnvironmentError(
          fmt::format("cannot create {}: {}; the folder must exist and be writable, or choose "
                      "another one",
                      name, Message(errno)));
    }
  }
  ~Descriptor() { ::close(number_); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;

  [[nodiscard]] int number() const { return number_; }

 private:
  int number_;
};

/// A file in memory; gnuplot reads its script from one and writes its complaints into another, so
/// that no pipe can fill up and no file stays behind.
Descriptor MemoryFile(const char* name) {
  return {::memfd_create(name, MFD_CLOEXEC), name};
}

void WriteAll(const Descriptor& file, std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = ::write(file.number(), text.data(), text.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) {
      throw EnvironmentError(fmt::format("cannot hand gnuplot its data: {}", Message(errno)));
    }
    text.remove_prefix(static_cast<std::size_t>(written));
  }
}

/// Up to 4 kB of `file` from `offset` on.
std::string ReadFrom(const Descriptor& file, off_t offset) {
  std::string text(4096, '\0');
  const ssize_t got = ::pread(file.number(), text.data(), text.size(), offset);
  text.resize(got > 0 ? static_cast<std::size_t>(got) : 0);
  return text;
}

/// Starts gnuplot with the three standard files, and waits. @returns its wait status.
int RunGnuplot(const Descriptor& in, const Descriptor& out, const Descriptor& error) {
  posix_spawn_file_actions_t files;
  ::posix_spawn_file_actions_init(&files);
  ::posix_spawn_file_actions_adddup2(&files, in.number(), STDIN_FILENO);
  ::posix_spawn_file_actions_adddup2(&files, out.number(), STDOUT_FILENO);
  ::posix_spawn_file_actions_adddup2(&files, error.number(), STDERR_FILENO);
  std::string program = "gnuplot";
  std::string no_user_settings = "-d";
  char* const arguments[] = {program.data(), no_user_settings.data(), nullptr};
  // What this program ignores, gnuplot need not.
  posix_spawnattr_t attributes;
  ::posix_spawnattr_init(&attributes);
  sigset_t signals;
  ::sigemptyset(&signals);
  ::sigaddset(&signals, SIGPIPE);
  ::posix_spawnattr_setsigdefault(&attributes, &signals);
  ::posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGDEF);
  pid_t process = 0;
  const int failed =
      ::posix_spawnp(&process, program.c_str(), &files, &attributes, arguments, environ);
  ::posix_spawnattr_destroy(&attributes);
  ::posix_spawn_file_actions_destroy(&files);
  if (failed != 0) {
    throw EnvironmentError(fmt::format(
        "cannot run gnuplot, which draws the plots: {}; install it (Debian: apt-get install "
        "gnuplot-nox) or put its folder on PATH",
        Message(failed)));
  }
  int status = 0;
  while (::waitpid(process, &status, 0) < 0 && errno == EINTR) {
  }
  return status;
}

}  // namespace

void DrawSvg(std::string_view script, const std::filesystem::path& path) {
  auto partial = path;
  partial += ".partial";
  const Descriptor in = MemoryFile("gnuplot script");
  const Descriptor error = MemoryFile("gnuplot messages");
  const Descriptor out(::open(partial.c_str(), O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0644),
                       partial.string());
  try {
    WriteAll(in, script);
    ::lseek(in.number(), 0, SEEK_SET);
    const int status = RunGnuplot(in, out, error);
    if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) {
      throw EnvironmentError(fmt::format("gnuplot failed on {} (wait status {}): {}", path.string(),
                                         status, ReadFrom(error, 0)));
    }
    // gnuplot does not tell when the disk is full.
    const off_t size = ::lseek(out.number(), 0, SEEK_END);
    if (ReadFrom(out, std::max<off_t>(size - 64, 0)).find("</svg>") == std::string::npos) {
      throw EnvironmentError(fmt::format("gnuplot wrote only a part of {}; is the disk full? {}",
                                         path.string(), ReadFrom(error, 0)));
    }
    std::filesystem::rename(partial, path);
  } catch (const std::filesystem::filesystem_error& failure) {
    ::unlink(partial.c_str());
    throw EnvironmentError(fmt::format("cannot rename {} to its final name: {}", partial.string(),
                                       failure.code().message()));
  } catch (...) {
    ::unlink(partial.c_str());
    throw;
  }
}

}  // namespace twin::report
