#pragma once

#include <cstdint>
#include <string_view>

#include "twin/core/random.h"
#include "twin/core/realtime.h"
#include "twin/core/time.h"
#include "twin/rt/delay_model.h"
#include "twin/rt/loss_model.h"

namespace twin::rt {

/// What one direction of a link does to its messages.
struct DirectionConfig {
  DelayModel delay;            ///< of every message
  LossModel loss;              ///< which messages never arrive
  double duplication = 0;      ///< probability that a message arrives a second time, in [0, 1]
  DelayModel duplicate_delay;  ///< how long after the first
  double reordering = 0;       ///< probability that a message is held back, in [0, 1]
  Duration reorder_by{};       ///< by so much, so that later ones overtake it; in [0, 1 h], above
                               ///< 0 when reordering is

  /// @param where  prefix of the fields' names in the text: "link.state".
  /// @throws InputError naming field, value and range.
  void Validate(std::string_view where) const;
};

/// What becomes of one message.
struct Fate {
  bool lost = false;           ///< no copy arrives; nothing below counts
  Duration delay{};            ///< from sending to arrival, a hold-back included
  bool duplicated = false;     ///< a second copy arrives
  Duration duplicate_delay{};  ///< of the second copy, from sending to arrival; >= delay

  bool operator==(const Fate&) const = default;
};

/// Where the draws of one direction come from.
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

/// The fates of the messages of one direction, drawn from the run's seed; whatever carries the
/// messages asks here. The fate of a message is a function of (config, seed, streams, number,
/// repeat), in any order of calls.
///
/// Threads: one. Real-time: Of() is noexcept, allocates nothing, bounded as LossProcess is.
class MessageFate {
 public:
  /// @throws InputError naming the field of `config` that is out of range.
  MessageFate(const DirectionConfig& config, std::uint64_t seed, const FateStreams& streams);

  /// @param number  of the message.
  /// @param repeat  0, or counts further messages of the same number. They go the same way at the
  /// same time, so only their loss is drawn apart.
  [[nodiscard]] Fate Of(std::uint64_t number, std::uint32_t repeat = 0) noexcept TWIN_REALTIME;

 private:
  DirectionConfig config_;
  LossProcess loss_;
  Random delay_;
  Random duplicate_;
  Random reorder_;
};

}  // namespace twin::rt
