#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "twin/core/realtime.h"
#include "twin/core/time.h"
#include "twin/faults/message_fate.h"

namespace twin::teleop {

/// Random streams of the two directions.
inline constexpr faults::FateStreams kToRobotStreams{.delay = RandomStream::kOperatorDelay,
                                                     .loss = RandomStream::kOperatorLoss,
                                                     .burst = RandomStream::kOperatorBurst,
                                                     .duplicate = RandomStream::kOperatorDuplicate,
                                                     .reorder = RandomStream::kOperatorReorder};
inline constexpr faults::FateStreams kFromRobotStreams{
    .delay = RandomStream::kFeedbackDelay,
    .loss = RandomStream::kFeedbackLoss,
    .burst = RandomStream::kFeedbackBurst,
    .duplicate = RandomStream::kFeedbackDuplicate,
    .reorder = RandomStream::kFeedbackReorder};

/// One direction between operator and robot; delays and loses messages by the run's seed. A
/// message's fate is a function of its sequence; a message that arrives after a newer one is
/// dropped. The callers give the time, virtual or real.
///
/// Threads: one. Real-time: Send() and Take() are noexcept and do not allocate; O(pending
/// messages).
/// @tparam Message  trivially copyable, with a `sequence` that rises from 1.
template <typename Message>
class Wire {
 public:
  static constexpr std::size_t kMostOnTheWay = 4096;  ///< messages beyond it are lost

  /// @throws InputError naming the field of `config` that is out of range.
  Wire(const faults::DirectionConfig& config, std::uint64_t seed,
       const faults::FateStreams& streams)
      : fate_(config, seed, streams) {
    on_the_way_.reserve(kMostOnTheWay);
  }

  void Send(Time now, const Message& message) noexcept TWIN_REALTIME {
    ++sent_;
    const faults::Fate fate = fate_.Of(message.sequence);
    if (fate.lost) return;
    Put(now + fate.delay, message);
    if (fate.duplicated) Put(now + fate.duplicate_delay, message);
  }

  /// @returns the newest arrived message, if newer than all taken before.
  [[nodiscard]] std::optional<Message> Take(Time now) noexcept TWIN_REALTIME {
    std::optional<Message> newest;
    for (std::size_t i = 0; i < on_the_way_.size();) {
      if (on_the_way_[i].at > now) {
        ++i;
        continue;
      }
      const Message& message = on_the_way_[i].message;
      if (message.sequence > taken_) {
        taken_ = message.sequence;
        newest = message;
      }
      on_the_way_[i] = on_the_way_.back();
      on_the_way_.pop_back();
    }
    return newest;
  }

  [[nodiscard]] std::uint64_t sent() const noexcept { return sent_; }

 private:
  struct Copy {
    Time at{};
    Message message;
  };

  void Put(Time at, const Message& message) noexcept {
    if (on_the_way_.size() < kMostOnTheWay) on_the_way_.push_back({at, message});
  }

  faults::MessageFate fate_;
  std::vector<Copy> on_the_way_;
  std::uint64_t taken_ = 0;  ///< highest taken sequence
  std::uint64_t sent_ = 0;
};

}  // namespace twin::teleop
