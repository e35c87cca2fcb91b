#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <functional>
#include <mutex>
#include <stop_token>
#include <thread>
#include <vector>

namespace twin::run {

/// Threads that share pieces of work which do not depend on each other, such as robots to step.
/// What a piece computes does not depend on the thread that takes it, nor on their number.
///
/// Threads: ForEach() from one at a time.
class WorkPool {
 public:
  /// @param threads  at work at once, the caller's included. @throws InputError unless in [1, 256].
  explicit WorkPool(int threads);

  /// Calls work(0), ..., work(count - 1), each once, and waits for all of them.
  /// @throws the exception of the lowest of those that throw, after all have ended.
  void ForEach(std::size_t count, const std::function<void(std::size_t)>& work);

 private:
  void Run(const std::stop_token& stop);
  /// Takes pieces until none is left. @param lock  on mutex_; held on return.
  void Take(std::unique_lock<std::mutex>& lock);

  std::mutex mutex_;
  std::condition_variable_any begun_;
  std::condition_variable_any ended_;
  // All guarded by mutex_.
  const std::function<void(std::size_t)>* work_ = nullptr;
  std::size_t count_ = 0;
  std::size_t next_ = 0;  ///< the piece to be taken next
  std::size_t done_ = 0;  ///< pieces ended
  std::exception_ptr error_;
  std::size_t failed_ = 0;             ///< the piece that threw error_
  std::vector<std::jthread> threads_;  // last, so that they stop before the rest is destroyed
};

}  // namespace twin::run
