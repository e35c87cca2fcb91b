#pragma once

#include <cstdint>
#include <variant>
#include <vector>

#include "twin/core/random.h"
#include "twin/core/realtime.h"

namespace twin::faults {

/// Every message is lost with the same probability, independently.
struct IndependentLoss {
  double probability = 0;  ///< in [0, 1]
};

/// Bursts: a two-state chain, stepped once per message, with a loss probability per state (Gilbert
/// 1960, Elliott 1963). With p = good_to_bad and r = bad_to_good, the share of bad messages is p /
/// (p + r) and the mean length of a bad burst 1 / r.
struct GilbertElliottLoss {
  double good_to_bad = 0;  ///< probability per message, in [0, 1]
  double bad_to_good = 1;  ///< per message, in (0, 1]; its inverse is the mean burst length
  double loss_good = 0;    ///< in [0, 1]
  double loss_bad = 1;     ///< in [0, 1]
};

/// Loses exactly these messages: for tests and to replay a measured incident.
struct ScriptedLoss {
  /// `count` consecutive messages, from number `first` on.
  struct Run {
    std::uint64_t first = 0;
    std::uint64_t count = 1;
  };
  std::vector<Run> runs;  ///< each with at least one message, increasing, not overlapping
};

/// Selects the lost messages of a numbered stream, drawn from the run's seed.
class LossModel {
 public:
  LossModel() = default;  ///< loses no message
  /// @throws InputError naming the field when a parameter is outside its range.
  explicit LossModel(const IndependentLoss& independent);
  explicit LossModel(const GilbertElliottLoss& gilbert_elliott);
  explicit LossModel(ScriptedLoss scripted);

  using Parameters = std::variant<IndependentLoss, GilbertElliottLoss, ScriptedLoss>;
  [[nodiscard]] const Parameters& parameters() const noexcept { return parameters_; }

 private:
  Parameters parameters_;
};

/// Applies a loss model to one stream. The loss of a message is a function of (model, seed,
/// streams, number, repeat), independent of the order and spacing of calls: the chain of a model
/// with memory steps through skipped numbers, and restarts from its stationary distribution at
/// every multiple of kBlock. This cuts bursts there, which matters only for bursts of about that
/// length.
///
/// Threads: one. Real-time: Loses() is noexcept, allocates nothing, O(1) for consecutive numbers,
/// otherwise O(numbers skipped), less than kBlock (a script: O(log runs)).
class LossProcess {
 public:
  static constexpr std::uint64_t kBlock = 4096;

  LossProcess(LossModel model, std::uint64_t seed, RandomStream loss, RandomStream burst);

  /// @param number  of the message.
  /// @param repeat  0, or counts further messages of the same number. They share the chain's state
  /// or the script; each has its own random loss.
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

}  // namespace twin::faults
