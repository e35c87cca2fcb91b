#include "twin/run/work_pool.h"

#include <utility>

#include "twin/core/error.h"

namespace twin::run {

WorkPool::WorkPool(int threads) {
  RequireInRange("threads", threads, 1, 256);
  for (int i = 1; i < threads; ++i) {
    threads_.emplace_back([this](const std::stop_token& stop) { Run(stop); });
  }
}

void WorkPool::ForEach(std::size_t count, const std::function<void(std::size_t)>& work) {
  std::unique_lock lock(mutex_);
  work_ = &work;
  count_ = count;
  next_ = done_ = 0;
  error_ = nullptr;
  begun_.notify_all();
  Take(lock);
  ended_.wait(lock, [this] { return done_ == count_; });
  work_ = nullptr;
  if (error_) std::rethrow_exception(std::exchange(error_, nullptr));
}

void WorkPool::Run(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  while (begun_.wait(lock, stop, [this] { return work_ != nullptr && next_ < count_; })) {
    Take(lock);
  }
}

void WorkPool::Take(std::unique_lock<std::mutex>& lock) {
  while (next_ < count_) {
    const std::size_t piece = next_++;
    lock.unlock();
    std::exception_ptr error;
    try {
      (*work_)(piece);
    } catch (...) {
      error = std::current_exception();
    }
    lock.lock();
    if (error && (!error_ || piece < failed_)) {
      error_ = error;
      failed_ = piece;
    }
    if (++done_ == count_) ended_.notify_all();
  }
}

}  // namespace twin::run
