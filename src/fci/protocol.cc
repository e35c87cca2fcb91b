#include "twin/fci/protocol.h"

#include <array>

namespace twin::fci {
namespace {

constexpr std::array<std::string_view, kHandCommands> kHandNames{"Connect", "Homing", "Grasp",
                                                                 "Move", "Stop"};
constexpr std::array<std::string_view, kVacuumCommands> kVacuumNames{"Connect", "Vacuum",
                                                                     "Drop Off", "Stop"};

template <typename Id, std::size_t kSize>
std::string_view NameIn(const std::array<std::string_view, kSize>& names, Id command) noexcept {
  const auto index = static_cast<std::size_t>(command);
  return index < kSize ? names[index] : "unknown";
}

}  // namespace

std::string_view Name(HandCommandId command) noexcept {
  return NameIn(kHandNames, command);
}

std::string_view Name(VacuumCommandId command) noexcept {
  return NameIn(kVacuumNames, command);
}

}  // namespace twin::fci
