#pragma once

#include <atomic>
#include <exception>
#include <string>

namespace twin::record {

/// First failure of a writer thread, readable by other threads.
///
/// Threads: Keep() from the writer; the rest from any.
class WriteFailure {
 public:
  /// Call in a catch block: keeps the current exception if it is the first.
  void Keep() noexcept {
    if (happened()) return;
    failure_ = std::current_exception();
    happened_.store(true, std::memory_order_release);  // publishes failure_
  }
  [[nodiscard]] bool happened() const noexcept { return happened_.load(std::memory_order_acquire); }
  /// @throws the kept exception, if any.
  void Rethrow() const {
    if (happened()) std::rethrow_exception(failure_);
  }
  /// Message of the failure; empty without one.
  [[nodiscard]] std::string Text() const {
    try {
      Rethrow();
    } catch (const std::exception& error) {
      return error.what();
    }
    return {};
  }

 private:
  std::exception_ptr failure_;  ///< constant once happened_ is set
  std::atomic<bool> happened_{false};
};

}  // namespace twin::record
