#include "twin/loop/communication_loop.h"

#include <algorithm>

#include "loop/trace_points.h"

namespace twin::loop {

CommunicationLoop::Outcome CommunicationLoop::OnState() noexcept {
  Time read{};
  TraceReadBegin(state_.message_id);
  switch (backend_.Read(rule_, state_, read)) {
    case backend::ReadResult::kPending: return Outcome::kPending;
    case backend::ReadResult::kLost: return Outcome::kLost;
    case backend::ReadResult::kState: break;
  }
  TraceStateRead(state_.message_id);
  command_ = Compute(state_, ReadAt(state_, read), cost_);
  return Outcome::kComputing;
}

void CommunicationLoop::Write() noexcept {
  if (command_ == nullptr) return;
  TraceWriteBegin(state_.message_id);
  backend_.Write(*command_);
  TraceWriteEnd(state_.message_id);
}

Time CommunicationLoop::OnDone(Time now) noexcept {
  record::TickRecord& record = tick_.record();
  if (command_ != nullptr) record.written = now;
  Count(record);
  if (InMotion()) deviation_.Measure(state_, record.read);
  if (command_ != nullptr) deviation_.Aim(state_.message_id, tick_.target());
  kept_[ticks_++ % kKept] = record;
  if (sink_ != nullptr) {
    sink_->Put(record);
    if (records_states_) PutState(record.read);
  }
  return NextRead(now);
}

void CommunicationLoop::PutState(Time read) noexcept {
  const bool follows = cycle_.state.message_id + 1 == state_.message_id;
  for (std::size_t i = 0; i < kJoints; ++i) {
    cycle_.dddq_d[i] = follows ? (state_.ddq_d[i] - cycle_.state.ddq_d[i]) / kCycleSeconds : 0;
  }
  cycle_.at = read;
  cycle_.state = state_;
  sink_->Put(cycle_);
}

void CommunicationLoop::Count(const record::TickRecord& record) noexcept {
  if (ticks_ > 0) timings_.period.Add(record.read - last_read_);
  last_read_ = record.read;
  timings_.skipped_states += record.skipped_states;
  timings_.anomalous += record.action == record::TickAction::kSkipped ? 1 : 0;
  timings_.stalled += record.stalled ? 1 : 0;
  if (command_ == nullptr) return;
  ++timings_.written;
  timings_.d_EXT.Add(record.written - record.read);
}

std::vector<record::TickRecord> CommunicationLoop::LastTicks() const {
  const std::size_t count = std::min(ticks_, kKept);
  std::vector<record::TickRecord> last(count);
  for (std::size_t i = 0; i < count; ++i) last[i] = kept_[(ticks_ - count + i) % kKept];
  return last;
}

}  // namespace twin::loop
