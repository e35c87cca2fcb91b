#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "twin/core/time.h"
#include "twin/rt/child_process.h"

namespace twin::render {

/// Owns a file descriptor.
class FileDescriptor {
 public:
  explicit FileDescriptor(int fd = -1) noexcept : fd_(fd) {}
  ~FileDescriptor() { Close(); }
  FileDescriptor(const FileDescriptor&) = delete;
  FileDescriptor& operator=(const FileDescriptor&) = delete;

  void Close() noexcept;
  void Reset(int fd) noexcept;
  [[nodiscard]] int get() const noexcept { return fd_; }

 private:
  int fd_;
};

/// How long ffmpeg may do nothing: take no frame, or not end once it has all.
inline constexpr Duration kFfmpegTimeout = std::chrono::seconds(60);

/// A running ffmpeg that reads its standard input from us and whose messages we keep.
///
/// Its standard input is a socket, so that writing to a dead ffmpeg is an error and never a SIGPIPE
/// (which would end the whole process); its messages go to a file in memory, so that it can never
/// block on them.
///
/// Threads: one thread.
class FfmpegProcess {
 public:
  /// @param program  looked up in PATH unless it has a slash.
  /// @param arguments  without the program's name.
  /// @param lock  descriptor that it inherits and holds until it ends; negative: none.
  /// @param timeout  as kFfmpegTimeout.
  /// @throws EnvironmentError when it cannot be started.
  FfmpegProcess(const std::string& program, const std::vector<std::string>& arguments,
                int lock = -1, Duration timeout = kFfmpegTimeout);

  /// Sends bytes to its standard input; waits while it is behind.
  /// @throws EnvironmentError when it has ended, with its last lines; when its timeout is over or
  /// the user wants to end (rt::GivesUp), it having been killed.
  void Send(std::span<const std::uint8_t> bytes);

  /// Ends its input and waits for it to end. @throws EnvironmentError when it failed, with its last
  /// lines, and as Send().
  void Finish();

 private:
  /// Until its input takes bytes, or it has ended.
  void WaitForRoom();
  /// Waits for it. @throws EnvironmentError always: why it ended and its last lines.
  [[noreturn]] void Fail(std::string_view when);
  /// Kills it. @throws EnvironmentError always.
  [[noreturn]] void FailSilent();
  [[nodiscard]] std::string LastMessages() const;

  const Duration timeout_;
  FileDescriptor input_;
  FileDescriptor messages_;
  std::optional<rt::ChildProcess> process_;  ///< always there; killed with this unless it has ended
};

}  // namespace twin::render
