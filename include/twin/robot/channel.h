#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "twin/core/realtime.h"
#include "twin/faults/message_fate.h"
#include "twin/robot/robot_config.h"
#include "twin/rt/event_queue.h"

namespace twin::robot {

/// Messages in flight in one direction. Each has a random fate, and each copy's arrival is an
/// event. Holds at most kCapacity, two per millisecond of the longest delay; further ones are lost.
///
/// A copy is for the link that was copied to go back to, together with its event queue.
///
/// Threads: that of the event queue. Real-time: allocates nothing after construction.
/// @tparam Message  with a message_id, the key of its fate.
template <typename Message>
class Channel {
 public:
  static constexpr std::size_t kCapacity = 2 * (kLongestOnTheWay / kCycle + 1);

  /// @throws InputError naming the field of `config` that is out of range.
  Channel(const faults::DirectionConfig& config, std::uint64_t seed,
          const faults::FateStreams& streams, rt::EventQueue& events, rt::EventOrder order);

  /// Draws the fates of later messages anew. @throws as the constructor.
  void Renew(const faults::DirectionConfig& config, std::uint64_t seed,
             const faults::FateStreams& streams) {
    fate_ = faults::MessageFate(config, seed, streams);
  }

  /// @param arrived  handles an event per arriving copy, with the token for Receive().
  /// @param repeat  counts messages of the same message_id; see faults::MessageFate.
  /// @returns the fate; also lost if the delay is too long or the channel is full.
  faults::Fate Send(const Message& message, rt::EventHandler& arrived,
                    std::uint32_t repeat = 0) noexcept TWIN_REALTIME;

  /// @pre called once per event. @returns the message, valid until the next Send().
  [[nodiscard]] const Message& Receive(std::uint64_t token) noexcept TWIN_REALTIME;

 private:
  struct Slot {
    Message message;
    int copies = 0;  ///< in flight
  };

  faults::MessageFate fate_;
  rt::EventQueue* events_;
  rt::EventOrder order_;
  std::vector<Slot> slots_;
  std::vector<std::size_t> free_;  ///< slots without a copy; the last one freed is used first
};

template <typename Message>
Channel<Message>::Channel(const faults::DirectionConfig& config, std::uint64_t seed,
                          const faults::FateStreams& streams, rt::EventQueue& events,
                          rt::EventOrder order)
    : fate_(config, seed, streams), events_(&events), order_(order), slots_(kCapacity) {
  free_.reserve(kCapacity);
  for (std::size_t slot = kCapacity; slot > 0; --slot) free_.push_back(slot - 1);
}

template <typename Message>
faults::Fate Channel<Message>::Send(const Message& message, rt::EventHandler& arrived,
                                    std::uint32_t repeat) noexcept {
  faults::Fate fate = fate_.Of(message.message_id, repeat);
  if (fate.lost || fate.delay > kLongestOnTheWay || free_.empty()) return {.lost = true};
  const std::size_t index = free_.back();
  free_.pop_back();
  slots_[index].message = message;
  slots_[index].copies = 1;
  events_->Schedule(events_->Now() + fate.delay, order_, arrived, index);
  if (fate.duplicate_delay > kLongestOnTheWay) fate.duplicated = false;
  if (!fate.duplicated) return fate;
  slots_[index].copies = 2;
  events_->Schedule(events_->Now() + fate.duplicate_delay, order_, arrived, index);
  return fate;
}

template <typename Message>
const Message& Channel<Message>::Receive(std::uint64_t token) noexcept {
  Slot& slot = slots_[token];
  if (--slot.copies == 0) free_.push_back(token);
  return slot.message;
}

}  // namespace twin::robot
