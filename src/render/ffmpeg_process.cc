#include "render/ffmpeg_process.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "twin/core/check.h"
#include "twin/core/error.h"

namespace twin::render {
namespace {

/// How much of ffmpeg's messages an error carries.
constexpr off_t kMessageTail = 600;

[[noreturn]] void ThrowHostError(const char* call, int error) {
  throw EnvironmentError(
      fmt::format("video: {} failed ({}); the host is short of descriptors or "
                  "memory",
                  call, std::strerror(error)));
}

/// What the child starts with: its descriptors, default signals, a process group of its own.
class SpawnSettings {
 public:
  SpawnSettings(int input, int messages, int lock) {
    posix_spawn_file_actions_init(&actions_);
    posix_spawn_file_actions_adddup2(&actions_, input, STDIN_FILENO);
    posix_spawn_file_actions_addopen(&actions_, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
    posix_spawn_file_actions_adddup2(&actions_, messages, STDERR_FILENO);
    if (lock >= 0) posix_spawn_file_actions_adddup2(&actions_, lock, STDERR_FILENO + 1);

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
  posix_spawn_file_actions_t actions_;
  posix_spawnattr_t attributes_;
};

std::string DescribeEnd(int status) {
  if (WIFSIGNALED(status)) {
    return fmt::format("was ended by signal {} ({})", WTERMSIG(status),
                       strsignal(WTERMSIG(status)));
  }
  return fmt::format("ended with exit code {}", WEXITSTATUS(status));
}

bool Contains(const std::string& text, const char* part) {
  return text.find(part) != std::string::npos;
}

/// ffmpeg may end well though it could not write all.
bool LostData(const std::string& messages) {
  return Contains(messages, "No space left on device") || Contains(messages, "Error writing") ||
         Contains(messages, "Error closing");
}

const char* CureOf(const std::string& messages) {
  if (Contains(messages, "Unknown encoder")) {
    return "This ffmpeg was built without the encoder; Debian's package ffmpeg has it";
  }
  if (Contains(messages, "No space left on device")) {
    return "Make room on the disk, or choose another folder";
  }
  if (Contains(messages, "No such file") || Contains(messages, "Not a directory") ||
      Contains(messages, "ermission denied")) {
    return "Choose a folder that exists and may be written to";
  }
  return "Look at what the lines name";
}

}  // namespace

void FileDescriptor::Close() noexcept {
  Reset(-1);
}

void FileDescriptor::Reset(int fd) noexcept {
  if (fd_ >= 0) close(fd_);
  fd_ = fd;
}

FfmpegProcess::FfmpegProcess(const std::string& program, const std::vector<std::string>& arguments,
                             int lock) {
  int ends[2];
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0) {
    ThrowHostError("socketpair", errno);
  }
  input_.Reset(ends[0]);
  const FileDescriptor child_end(ends[1]);
  messages_.Reset(memfd_create("ffmpeg-messages", MFD_CLOEXEC));
  if (messages_.get() < 0) ThrowHostError("memfd_create", errno);
  Spawn(program, arguments, child_end.get(), lock);
}

FfmpegProcess::~FfmpegProcess() {
  input_.Close();
  Wait();
}

void FfmpegProcess::Spawn(const std::string& program, const std::vector<std::string>& arguments,
                          int input, int lock) {
  const SpawnSettings settings(input, messages_.get(), lock);
  std::vector<std::string> words{program};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  argv.reserve(words.size() + 1);
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  const int error = posix_spawnp(&pid_, program.c_str(), settings.actions(), settings.attributes(),
                                 argv.data(), environ);
  if (error != 0) {
    pid_ = -1;
    throw EnvironmentError(fmt::format(
        "video: \"{}\" cannot be started ({}). Install it (Debian: apt-get install ffmpeg), or run "
        "without video",
        program, std::strerror(error)));
  }
}

void FfmpegProcess::Send(std::span<const std::uint8_t> bytes) {
  TWIN_CHECK(input_.get() >= 0);
  while (!bytes.empty()) {
    const ssize_t sent = send(input_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (sent < 0 && errno == EINTR) continue;
    if (sent < 0) Fail();
    bytes = bytes.subspan(static_cast<std::size_t>(sent));
  }
}

void FfmpegProcess::Finish() {
  input_.Close();
  const int status = Wait();
  const std::string messages = LastMessages();
  if (status == 0 && !LostData(messages)) return;
  throw EnvironmentError(fmt::format("video: ffmpeg {}. Its last lines: {}. {}",
                                     DescribeEnd(status), messages, CureOf(messages)));
}

int FfmpegProcess::Wait() noexcept {
  if (pid_ < 0) return 0;
  int status = 0;
  while (waitpid(pid_, &status, 0) < 0 && errno == EINTR) {
  }
  pid_ = -1;
  return status;
}

void FfmpegProcess::Fail() {
  input_.Close();
  const int status = Wait();
  const std::string messages = LastMessages();
  throw EnvironmentError(
      fmt::format("video: ffmpeg {} while frames were still being sent. Its last lines: {}. {}",
                  DescribeEnd(status), messages, CureOf(messages)));
}

std::string FfmpegProcess::LastMessages() const {
  const off_t size = lseek(messages_.get(), 0, SEEK_END);
  std::string text(static_cast<std::size_t>(std::clamp<off_t>(size, 0, kMessageTail)), '\0');
  const auto offset = size - static_cast<off_t>(text.size());
  const ssize_t got = pread(messages_.get(), text.data(), text.size(), offset);
  text.resize(static_cast<std::size_t>(std::max<ssize_t>(got, 0)));
  while (!text.empty() && text.back() == '\n') text.pop_back();
  return text.empty() ? "(none)" : text;
}

}  // namespace twin::render
