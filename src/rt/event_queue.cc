#include "twin/rt/event_queue.h"

#include <algorithm>

#include "twin/core/error.h"

namespace twin::rt {

EventQueue::EventQueue(std::size_t capacity) : capacity_(capacity) {
  heap_.reserve(capacity);
}

bool EventQueue::Later(const Event& a, const Event& b) noexcept {
  if (a.at != b.at) return a.at > b.at;
  if (a.order != b.order) return a.order > b.order;
  return a.sequence > b.sequence;
}

void EventQueue::Schedule(Time at, EventOrder order, EventHandler& handler,
                          std::uint64_t token) noexcept {
  TWIN_CHECK(at >= now_ && heap_.size() < capacity_);
  heap_.push_back({at, next_sequence_++, &handler, token, order});
  std::push_heap(heap_.begin(), heap_.end(), &Later);
}

void EventQueue::AdvanceTo(Time at) noexcept {
  now_ = std::max(now_, heap_.empty() ? at : std::min(at, heap_.front().at));
}

bool EventQueue::RunNext() noexcept {
  if (heap_.empty()) return false;
  std::pop_heap(heap_.begin(), heap_.end(), &Later);
  const Event event = heap_.back();
  heap_.pop_back();
  now_ = event.at;
  event.handler->OnEvent(now_, event.token);
  return true;
}

}  // namespace twin::rt
