#include "twin/fci/protocol.h"

#include <array>

namespace twin::fci {
namespace {

constexpr std::array<std::string_view, kArmCommands> kArmNames{
    "Connect",
    "Move",
    "Stop Move",
    "Get Cartesian Limit",
    "Set Collision Behavior",
    "Set Joint Impedance",
    "Set Cartesian Impedance",
    "Set Guiding Mode",
    "Set EE to K",
    "Set NE to EE",
    "Set Load",
    "Set Filters",
    "Automatic Error Recovery",
    "Load Model Library",
};

constexpr std::array<std::string_view, kHandCommands> kHandNames{"Connect", "Homing", "Grasp",
                                                                 "Move", "Stop"};

}  // namespace

std::string_view Name(ArmCommand command) noexcept {
  const auto index = static_cast<std::size_t>(command);
  return index < kArmNames.size() ? kArmNames[index] : "unknown";
}

std::string_view Name(HandCommandId command) noexcept {
  const auto index = static_cast<std::size_t>(command);
  return index < kHandNames.size() ? kHandNames[index] : "unknown";
}

}  // namespace twin::fci
