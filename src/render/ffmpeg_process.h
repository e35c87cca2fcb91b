#pragma once

#include <sys/types.h>

#include <cstdint>
#include <span>
#include <string>
#include <vector>

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
  /// @throws EnvironmentError when it cannot be started.
  FfmpegProcess(const std::string& program, const std::vector<std::string>& arguments,
                int lock = -1);

  /// Ends its input and waits for it to end.
  ~FfmpegProcess();
  FfmpegProcess(const FfmpegProcess&) = delete;
  FfmpegProcess& operator=(const FfmpegProcess&) = delete;

  /// Sends bytes to its standard input; waits while it is behind.
  /// @throws EnvironmentError when it has ended, with its last lines.
  void Send(std::span<const std::uint8_t> bytes);

  /// Ends its input and waits for it to end.
  /// @throws EnvironmentError when it failed, with its last lines.
  void Finish();

 private:
  void Spawn(const std::string& program, const std::vector<std::string>& arguments, int input,
             int lock);
  /// Waits for the process. @returns the status of waitpid().
  int Wait() noexcept;
  /// Waits for the process. @throws EnvironmentError always: why it ended and its last lines.
  [[noreturn]] void Fail();
  [[nodiscard]] std::string LastMessages() const;

  pid_t pid_ = -1;
  FileDescriptor input_;
  FileDescriptor messages_;
};

}  // namespace twin::render
