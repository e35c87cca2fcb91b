#include "twin/loop/shared_time.h"

#include <utility>

namespace twin::loop {

SharedTime::SharedTime(std::size_t robots, rt::ThreadSettings thread, std::function<void()> on_stop)
    : thread_(std::move(thread), std::move(on_stop)),
      all_(static_cast<std::ptrdiff_t>(robots), Next{this}) {}

void SharedTime::Advance() noexcept {
  if (std::exchange(runs_, true)) return thread_.Stop();
  clock_->Restart();
  try {
    notices_ = thread_.Start();
  } catch (...) {
    failure_ = std::current_exception();
  }
}

SharedTime::Seat::Seat(SharedTime& time, std::function<void()> on_end)
    : time_(time), on_end_(std::move(on_end)), ready_(time.ready_) {}

SharedTime::Seat::~Seat() {
  End();
  if (!has_begun_) time_.all_.arrive_and_drop();
}

void SharedTime::Seat::Begin() {
  has_begun_ = true;
  ready_.unlock();
  time_.all_.arrive_and_wait();
  if (time_.failure_) std::rethrow_exception(time_.failure_);
}

void SharedTime::Seat::End() {
  if (!has_begun_ || std::exchange(has_ended_, true)) return;
  if (on_end_) on_end_();
  const Time begin = time_.clock_->Now();
  time_.all_.arrive_and_wait();
  waited_ = time_.clock_->Now() - begin;
}

}  // namespace twin::loop
