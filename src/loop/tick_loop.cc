#include "twin/loop/tick_loop.h"

namespace twin::loop {

bool TickLoop::OnState() noexcept {
  if (computing_) return false;
  Time arrival{};
  if (backend_.Read(backend::ReadRule::kFresh, state_, arrival) != backend::ReadResult::kState) {
    return false;
  }
  command_ = tick_.Tick(state_, arrival);
  skipped_ += tick_.record().skipped_states;
  current_cost_ = cost_.Draw(random_, state_.message_id);
  computing_ = true;
  return true;
}

void TickLoop::OnDone(Time now) noexcept {
  computing_ = false;
  if (command_ != nullptr) {
    backend_.Write(*command_);
    ++written_;
    tick_.record().written = now;
  }
  if (sink_ != nullptr) sink_->Put(tick_.record());
}

}  // namespace twin::loop
