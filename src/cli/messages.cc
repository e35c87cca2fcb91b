#include "cli/messages.h"

#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <deque>
#include <mutex>
#include <string_view>
#include <utility>

#include <fmt/format.h>

namespace twin::cli {
namespace {

constexpr std::size_t kMostBytes = std::size_t{64} << 10;
constexpr std::chrono::milliseconds kTimeout{200};

/// A failure is ignored, as by Say().
void Write(std::string_view text) noexcept {
  while (!text.empty()) {
    const auto written = ::write(STDOUT_FILENO, text.data(), text.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return;
    text.remove_prefix(static_cast<std::size_t>(written));
  }
}

}  // namespace

class Messages::Queue {
 public:
  void Put(std::string text) {
    const std::lock_guard lock(mutex_);
    if (bytes_ + text.size() > kMostBytes) {
      ++dropped_;
      return;
    }
    TellDropped();
    Add(std::move(text));
  }

  /// The writer's: until End(), and nothing is left.
  void WriteAll() {
    std::unique_lock lock(mutex_);
    for (;;) {
      changed_.wait(lock, [this] { return ends_ || !texts_.empty(); });
      if (texts_.empty()) break;
      const std::string text = std::move(texts_.front());
      texts_.pop_front();
      lock.unlock();
      Write(text);
      lock.lock();
      bytes_ -= text.size();
      ++written_;
      changed_.notify_all();
    }
    is_done_ = true;
    changed_.notify_all();
  }

  /// @returns whether all is written.
  bool End() {
    std::unique_lock lock(mutex_);
    TellDropped();
    ends_ = true;
    changed_.notify_all();
    for (std::uint64_t before = written_; !is_done_; before = written_) {
      const auto moves = [&] { return is_done_ || written_ > before; };
      if (!changed_.wait_for(lock, kTimeout, moves)) return false;
    }
    return true;
  }

 private:
  void TellDropped() {
    if (dropped_ == 0) return;
    Add(fmt::format("{:10} lines were not printed: nobody read for too long\n", dropped_));
    dropped_ = 0;
  }
  void Add(std::string text) {
    bytes_ += text.size();
    texts_.push_back(std::move(text));
    changed_.notify_all();
  }

  std::mutex mutex_;  ///< guards all
  std::condition_variable changed_;
  std::deque<std::string> texts_;
  std::size_t bytes_ = 0;      ///< of texts_, and of the one that is being written
  std::uint64_t dropped_ = 0;  ///< since the last text that was taken
  std::uint64_t written_ = 0;
  bool ends_ = false;
  bool is_done_ = false;
};

Messages::Messages() : queue_(std::make_shared<Queue>()) {
  static_cast<void>(std::fflush(stdout));
  writer_ = std::thread([queue = queue_] { queue->WriteAll(); });
}

Messages::~Messages() {
  queue_->End() ? writer_.join() : writer_.detach();
}

void Messages::Put(std::string text) {
  queue_->Put(std::move(text));
}

}  // namespace twin::cli
