#include "twin/fci/protocol.h"

#include <array>

namespace twin::fci {
namespace {

constexpr std::array<std::string_view, kHandCommands> kHandNames{"Connect", "Homing", "Grasp",
                                                                 "Move", "Stop"};

}  // namespace

std::string_view Name(HandCommandId command) noexcept {
  const auto index = static_cast<std::size_t>(command);
  return index < kHandNames.size() ? kHandNames[index] : "unknown";
}

}  // namespace twin::fci
