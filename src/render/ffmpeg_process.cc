#include "render/ffmpeg.h"

#include <fmt/format.h>
#include <poll.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <system_error>

#include "twin/core/clock.h"
#include "twin/core/error.h"

namespace twin::render {
namespace {

/// Length of ffmpeg's messages in an error.
constexpr off_t kMessageTail = 600;

[[noreturn]] void ThrowHostError(const char* call, int error) {
  throw EnvironmentError(
      fmt::format("video: {} failed ({}); the host is short of descriptors or "
                  "memory",
                  call, std::strerror(error)));
}

bool Contains(const std::string& text, const char* part) {
  return text.find(part) != std::string::npos;
}

/// ffmpeg may exit with success though it could not write all data.
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
                             int lock, Duration timeout)
    : timeout_(timeout) {
  int ends[2];
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0) {
    ThrowHostError("socketpair", errno);
  }
  input_.Reset(ends[0]);
  const FileDescriptor child_end(ends[1]);
  messages_.Reset(memfd_create("ffmpeg-messages", MFD_CLOEXEC));
  if (messages_.get() < 0) ThrowHostError("memfd_create", errno);
  try {
    process_.emplace(program, arguments,
                     rt::ChildProcess::Files{
                         .in = child_end.get(), .error = messages_.get(), .kept_open = lock});
  } catch (const std::system_error& error) {
    throw EnvironmentError(fmt::format(
        "video: \"{}\" cannot be started ({}). Install it (Debian: apt-get install ffmpeg), or run "
        "without video",
        program, error.code().message()));
  }
}

void FfmpegProcess::Send(std::span<const std::uint8_t> bytes) {
  TWIN_CHECK(input_.get() >= 0);
  while (!bytes.empty()) {
    WaitForRoom();
    const ssize_t sent =
        send(input_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
    if (sent < 0 && (errno == EINTR || errno == EAGAIN)) continue;
    if (sent < 0) Fail(" while frames were still being sent");
    bytes = bytes.subspan(static_cast<std::size_t>(sent));
  }
}

void FfmpegProcess::WaitForRoom() {
  constexpr int kLookMs = 20;
  const MonotonicClock clock;
  pollfd room{.fd = input_.get(), .events = POLLOUT, .revents = 0};
  while (poll(&room, 1, kLookMs) <= 0) {
    if (rt::GivesUp() || clock.Now().time_since_epoch() >= timeout_) FailSilent();
  }
}

void FfmpegProcess::Finish() {
  input_.Close();
  const std::optional<int> status = process_->Wait(timeout_);
  if (!status) FailSilent();
  const std::string messages = LastMessages();
  if (*status == 0 && !LostData(messages)) return;
  throw EnvironmentError(fmt::format("video: ffmpeg {}. Its last lines: {}. {}",
                                     rt::DescribeEnd(*status), messages, CureOf(messages)));
}

void FfmpegProcess::Fail(std::string_view when) {
  input_.Close();
  const std::optional<int> status = process_->Wait(timeout_);
  if (!status) FailSilent();
  const std::string messages = LastMessages();
  throw EnvironmentError(fmt::format("video: ffmpeg {}{}. Its last lines: {}. {}",
                                     rt::DescribeEnd(*status), when, messages, CureOf(messages)));
}

void FfmpegProcess::FailSilent() {
  process_->Kill();
  if (rt::GivesUp()) throw EnvironmentError("video: interrupted; ffmpeg was ended");
  throw EnvironmentError(
      fmt::format("video: ffmpeg did nothing for {} s, and was ended. Its last lines: {}. Look at "
                  "what it waits for, or run without video",
                  ToSeconds(timeout_), LastMessages()));
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
