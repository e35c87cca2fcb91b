#pragma once

#include <cstdint>
#include <variant>
#include <vector>

#include "twin/core/random.h"
#include "twin/core/realtime.h"

namespace twin::rt {

/// Every message is lost with the same probability, whatever happened to the others.
struct IndependentLoss {
  double probability = 0;  ///< in [0, 1]
};

/// Bursts: a chain of two states, stepped once per message, each state with its own loss
/// probability (Gilbert 1960, Elliott 1963). With p = good_to_bad and r = bad_to_good the share of
/// bad messages is p / (p + r), the mean length of a burst of them 1 / r.
struct GilbertElliottLoss {
  double good_to_bad = 0;  ///< probability per message, in [0, 1]
  double bad_to_good = 1;  ///< probability per message, in (0, 1]; its inverse: mean burst length
  double loss_good = 0;    ///< in [0, 1]
  double loss_bad = 1;     ///< in [0, 1]
};

/// Exactly these messages are lost: for tests and for what happened once in a laboratory.
struct ScriptedLoss {
  /// `count` messages in a row, the first with number `first`.
  struct Run {
    std::uint64_t first = 0;
    std::uint64_t count = 1;
  };
  std::vector<Run> runs;  ///< each of at least one message, rising, not overlapping
};

/// Which messages of a numbered stream are lost, drawn from the run's seed.
class LossModel {
 public:
  LossModel() = default;  ///< no message is lost
  /// @throws InputError naming the field when a parameter is outside its range.
  explicit LossModel(const IndependentLoss& independent);
  explicit LossModel(const GilbertElliottLoss& gilbert_elliott);
  explicit LossModel(ScriptedLoss scripted);

  using Parameters = std::variant<IndependentLoss, GilbertElliottLoss, ScriptedLoss>;
  [[nodiscard]] const Parameters& parameters() const noexcept { return parameters_; }

 private:
  Parameters parameters_;
};

/// A loss model at work on one stream. The loss of a message is a function of (model, seed,
/// streams, number, repeat), in any order of calls and however they are spaced: the chain of a
/// model with memory is stepped through the numbers in between, and drawn anew from its stationary
/// distribution at every multiple of kBlock. That cuts bursts there, which matters only when they
/// are about as long.
///
/// Threads: one. Real-time: Loses() is noexcept, allocates nothing, O(1) for rising numbers without
/// gaps, otherwise O(numbers passed over), fewer than kBlock (a script: O(log runs)).
class LossProcess {
 public:
  static constexpr std::uint64_t kBlock = 4096;

  LossProcess(LossModel model, std::uint64_t seed, RandomStream loss, RandomStream burst);

  /// @param number  of the message.
  /// @param repeat  0, or counts further messages of the same number. They meet the same state of
  /// the chain or the same script; the loss itself is drawn for each.
  [[nodiscard]] bool Loses(std::uint64_t number, std::uint32_t repeat = 0) noexcept TWIN_REALTIME;

 private:
  [[nodiscard]] bool InBadState(const GilbertElliottLoss& chain, std::uint64_t number) noexcept;

  LossModel model_;
  Random loss_;
  Random burst_;
  bool bad_ = false;
  bool started_ = false;
  std::uint64_t last_number_ = 0;
};

}  // namespace twin::rt
