#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "twin/core/time.h"
#include "twin/record/partial_output.h"
#include "twin/render/video_writer.h"
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

/// Longest time for ffmpeg to take a frame, or to end after the last one.
inline constexpr Duration kFfmpegTimeout = std::chrono::seconds(60);

/// A running ffmpeg that reads its standard input from us; its messages are kept.
///
/// Its standard input is a socket, so that writing to a dead ffmpeg is an error and never a SIGPIPE
/// (which would end the whole process). Its messages go to an in-memory file, so that it never
/// blocks on them.
///
/// Threads: one thread.
class FfmpegProcess {
 public:
  /// @param program  looked up in PATH unless it has a slash.
  /// @param arguments  without the program's name.
  /// @param lock  descriptor that it inherits and holds until it ends; negative: none.
  /// @param timeout  as kFfmpegTimeout.
  /// @throws EnvironmentError if it cannot be started.
  FfmpegProcess(const std::string& program, const std::vector<std::string>& arguments,
                int lock = -1, Duration timeout = kFfmpegTimeout);

  /// Writes to its standard input; waits while ffmpeg lags.
  /// @throws EnvironmentError if it has ended, with its last lines; after killing it, if the
  /// timeout has passed or the user wants to end (rt::GivesUp).
  void Send(std::span<const std::uint8_t> bytes);

  /// Closes its input and waits for its end. @throws EnvironmentError if it failed, with its last
  /// lines, and as Send().
  void Finish();

 private:
  /// Waits until its input takes bytes, or it has ended.
  void WaitForRoom();
  /// Waits for its end. @throws EnvironmentError always, with the cause and its last lines.
  [[noreturn]] void Fail(std::string_view when);
  /// Kills it. @throws EnvironmentError always.
  [[noreturn]] void FailSilent();
  [[nodiscard]] std::string LastMessages() const;

  const Duration timeout_;
  FileDescriptor input_;
  FileDescriptor messages_;
  std::optional<rt::ChildProcess> process_;  ///< always set; killed on destruction if running
};

/// @returns the arguments for ffmpeg to encode raw RGB pictures from its standard input.
/// @param output  file; for pictures an existing folder.
[[nodiscard]] std::vector<std::string> FfmpegArguments(const VideoSettings& settings,
                                                       VideoFormat format,
                                                       const std::filesystem::path& output);

/// Path of a video: a partial output beside it until it is complete.
class VideoTarget {
 public:
  /// Creates and locks the partial output, and removes an earlier run's pictures from it.
  /// @throws InputError as CheckVideoPath(); EnvironmentError as record::PartialOutput.
  explicit VideoTarget(const std::filesystem::path& path);
  /// Removes the partial output unless it was published.
  ~VideoTarget();
  VideoTarget(const VideoTarget&) = delete;
  VideoTarget& operator=(const VideoTarget&) = delete;

  [[nodiscard]] VideoFormat format() const noexcept { return format_; }
  [[nodiscard]] const std::filesystem::path& partial() const noexcept { return output_.partial(); }
  /// @returns its lock, for the process that writes it.
  [[nodiscard]] int lock() const noexcept { return output_.lock(); }

  /// Renames the partial video to its path, replacing an older one.
  /// @throws EnvironmentError if the system refuses.
  void Publish();

 private:
  VideoFormat format_;
  std::filesystem::path path_;
  record::PartialOutput output_;
};

}  // namespace twin::render
