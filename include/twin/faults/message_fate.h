#pragma once

#include <cstdint>
#include <string_view>

#include "twin/core/random.h"
#include "twin/core/realtime.h"
#include "twin/core/time.h"
#include "twin/faults/delay_model.h"
#include "twin/faults/loss_model.h"

namespace twin::faults {

/// Faults of one direction of a link.
struct DirectionConfig {
  DelayModel delay;            ///< of every message
  LossModel loss;              ///< messages that never arrive
  double duplication = 0;      ///< probability of a second copy, in [0, 1]
  DelayModel duplicate_delay;  ///< of the copy, after the first
  double reordering = 0;       ///< probability of a hold-back, in [0, 1]
  Duration reorder_by{};       ///< time of a hold-back, so that later messages overtake; in [0, 1
                               ///< h], > 0 if reordering is

  /// @param where  prefix of the fields in messages: "link.state".
  /// @throws InputError naming field, value and range.
  void Validate(std::string_view where) const;
};

/// Fate of one message.
struct Fate {
  bool lost = false;           ///< no copy arrives; the rest is unused
  Duration delay{};            ///< from sending to arrival, including a hold-back
  bool duplicated = false;     ///< a second copy arrives
  Duration duplicate_delay{};  ///< of the second copy, from sending to arrival; >= delay

  bool operator==(const Fate&) const = default;
};

/// Random streams of one direction.
struct FateStreams {
  RandomStream delay;
  RandomStream loss;
  RandomStream burst;
  RandomStream duplicate;
  RandomStream reorder;
};
inline constexpr FateStreams kStateStreams{.delay = RandomStream::kStateDelay,
                                           .loss = RandomStream::kStateLoss,
                                           .burst = RandomStream::kStateBurst,
                                           .duplicate = RandomStream::kStateDuplicate,
                                           .reorder = RandomStream::kStateReorder};
inline constexpr FateStreams kCommandStreams{.delay = RandomStream::kCommandDelay,
                                             .loss = RandomStream::kCommandLoss,
                                             .burst = RandomStream::kCommandBurst,
                                             .duplicate = RandomStream::kCommandDuplicate,
                                             .reorder = RandomStream::kCommandReorder};

/// Fates of the messages of one direction, drawn from the run's seed, for any transport. A fate is
/// a function of (config, seed, streams, number, repeat), independent of the order of calls.
///
/// Threads: one. Real-time: Of() is noexcept, allocates nothing, bounded as LossProcess is.
class MessageFate {
 public:
  /// @throws InputError naming the field of `config` that is out of range.
  MessageFate(const DirectionConfig& config, std::uint64_t seed, const FateStreams& streams);

  /// @param number  of the message.
  /// @param repeat  0, or counts further messages of the same number. They share delay and copies;
  /// only their loss is drawn separately.
  [[nodiscard]] Fate Of(std::uint64_t number, std::uint32_t repeat = 0) noexcept TWIN_REALTIME;

 private:
  DirectionConfig config_;
  LossProcess loss_;
  Random delay_;
  Random duplicate_;
  Random reorder_;
};

}  // namespace twin::faults
