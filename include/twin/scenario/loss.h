#pragma once

#include <cstdint>
#include <variant>
#include <vector>

#include "twin/core/time.h"
#include "twin/rt/loss_model.h"

namespace twin::scenario {

/// Every message is lost with the same probability.
struct IndependentLoss {
  double percent = 0;  ///< in [0, 100]
  bool operator==(const IndependentLoss&) const = default;
};

/// Bursts: a chain of a good and a bad state, stepped once per message; all in percent.
struct GilbertElliottLoss {
  double good_to_bad = 0;    ///< per message, in [0, 100]
  double bad_to_good = 100;  ///< per message, in (0, 100]; 100 over it: mean length of a burst
  double loss_good = 0;      ///< in [0, 100]
  double loss_bad = 100;     ///< in [0, 100]
  bool operator==(const GilbertElliottLoss&) const = default;
};

/// Exactly these messages.
struct ScriptedLoss {
  /// `count` messages in a row, the first with number at / 1 ms.
  struct Burst {
    Duration at{};            ///< since the first message, a whole number of ms, >= 0
    std::uint64_t count = 1;  ///< >= 1
    bool operator==(const Burst&) const = default;
  };
  std::vector<Burst> bursts;  ///< rising, not overlapping
  bool operator==(const ScriptedLoss&) const = default;
};

/// Which messages are lost: the parameters of an rt::LossModel as a scenario writes them.
struct Loss {
  using Law = std::variant<IndependentLoss, GilbertElliottLoss, ScriptedLoss>;
  Law law;

  /// @throws InputError when a parameter is outside its range.
  [[nodiscard]] rt::LossModel Model() const;
  bool operator==(const Loss&) const = default;
};

}  // namespace twin::scenario
