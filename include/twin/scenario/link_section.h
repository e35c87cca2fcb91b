#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <variant>
#include <vector>

#include "twin/core/time.h"
#include "twin/faults/delay_model.h"
#include "twin/faults/loss_model.h"
#include "twin/robot/robot_config.h"

// The section `link`, also by itself, and the laws of delays and losses.
namespace twin::scenario {

/// A law of delays: the parameters of an faults::DelayModel, as a value that can be compared and
/// written to a file.
struct Delay {
  using Law = std::variant<faults::ConstantDelay, faults::LogNormalDelay, faults::NormalDelay,
                           faults::GammaDelay, faults::EmpiricalDelay>;
  Law law;

  /// @throws InputError when a parameter is outside its range.
  [[nodiscard]] faults::DelayModel Model() const;
  bool operator==(const Delay& other) const;
};

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

/// A law of losses: the parameters of an faults::LossModel as a scenario writes them.
struct Loss {
  using Law = std::variant<IndependentLoss, GilbertElliottLoss, ScriptedLoss>;
  Law law;

  /// @throws InputError when a parameter is outside its range.
  [[nodiscard]] faults::LossModel Model() const;
  bool operator==(const Loss&) const = default;
};

/// Messages that arrive a second time.
struct Duplication {
  double share_percent = 0;  ///< of all messages, in [0, 100]
  Delay delay;               ///< of the second after the first
  bool operator==(const Duplication&) const = default;
};

/// Messages that are delayed, so that later ones overtake them.
struct Reordering {
  double share_percent = 0;  ///< of all messages, in [0, 100]
  Duration by{};             ///< >= 0
  bool operator==(const Reordering&) const = default;
};

struct DirectionSection {
  Delay delay;
  Loss loss;
  Duplication duplication;
  Reordering reordering;
  bool operator==(const DirectionSection&) const = default;
};

struct LinkSection {
  DirectionSection state;    ///< robot to workstation
  DirectionSection command;  ///< workstation to robot
  Duration d_INT = robot::LinkConfig().d_INT;
  bool operator==(const LinkSection&) const = default;
};

/// The configuration of a link. @throws InputError when a parameter is outside its range.
[[nodiscard]] robot::LinkConfig MakeLink(const LinkSection& link);

/// The configuration of one direction. @throws InputError as MakeLink.
[[nodiscard]] faults::DirectionConfig MakeDirection(const DirectionSection& direction);

/// @param path  a scenario, whose section `link` counts; or a file with that section only.
/// @throws InputError naming file, line and key.
[[nodiscard]] LinkSection LoadLink(const std::filesystem::path& path);

/// @param text  the keys of the section. @param file  its name in messages.
/// @throws InputError naming file, line and key.
[[nodiscard]] LinkSection ParseLink(const std::string& text, const std::filesystem::path& file);

}  // namespace twin::scenario
