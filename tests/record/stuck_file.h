#pragma once

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <stop_token>
#include <thread>
#include <vector>

namespace twin::record {

/// A file on a disk that is stuck: a pipe, into which a writer may put 64 kB before it blocks.
class StuckFile {
 public:
  explicit StuckFile(const std::filesystem::path& path) {
    EXPECT_EQ(::mkfifo(path.c_str(), 0600), 0);
    pipe_ = ::open(path.c_str(), O_RDWR | O_CLOEXEC | O_NONBLOCK);
  }
  ~StuckFile() {
    reader_ = {};  // ended before its pipe is closed
    ::close(pipe_);
  }
  StuckFile(const StuckFile&) = delete;
  StuckFile& operator=(const StuckFile&) = delete;

  /// From here on the disk takes what it is given.
  void Release() {
    reader_ = std::jthread([pipe = pipe_](const std::stop_token& stop) {
      std::vector<char> buffer(1 << 16);
      while (!stop.stop_requested()) {
        if (::read(pipe, buffer.data(), buffer.size()) <= 0) std::this_thread::yield();
      }
    });
  }

 private:
  int pipe_ = -1;
  std::jthread reader_;
};

}  // namespace twin::record
