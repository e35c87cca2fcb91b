#pragma once

#include <atomic>
#include <exception>
#include <string>

namespace twin::record {

/// The first failure of a writer thread, for those who look on.
///
/// Threads: Keep() from the writer; the rest from any.
class WriteFailure {
 public:
  /// In a catch block: keeps what is thrown, if it is the first.
  void Keep() noexcept {
    if (happened()) return;
    failure_ = std::current_exception();
    happened_.store(true, std::memory_order_release);  // after what it tells of
  }
  [[nodiscard]] bool happened() const noexcept { return happened_.load(std::memory_order_acquire); }
  /// @throws what was kept, if anything.
  void Rethrow() const {
    if (happened()) std::rethrow_exception(failure_);
  }
  /// What it says; empty: nothing has failed.
  [[nodiscard]] std::string Text() const {
    try {
      Rethrow();
    } catch (const std::exception& error) {
      return error.what();
    }
    return {};
  }

 private:
  std::exception_ptr failure_;  ///< not changed once happened_
  std::atomic<bool> happened_{false};
};

}  // namespace twin::record
