#include <fmt/format.h>

#include "fci/device_requests.h"
#include "twin/core/error.h"

namespace twin::fci {
namespace {

struct VacuumNumbers {
  VacuumCommandId operator()(const Connect&) { return VacuumCommandId::kConnect; }
  VacuumCommandId operator()(const hand::Vacuum&) { return VacuumCommandId::kVacuum; }
  VacuumCommandId operator()(const hand::DropOff&) { return VacuumCommandId::kDropOff; }
  VacuumCommandId operator()(const hand::Stop&) { return VacuumCommandId::kStop; }
  /// The hand's.
  VacuumCommandId operator()(const auto&) {
    TWIN_CHECK(false);
    return {};
  }
};

}  // namespace

std::variant<HandRequest, BadFrame> ParseVacuumRequest(const Frame& frame) {
  using Id = VacuumCommandId;
  switch (frame.head.command) {
    case static_cast<std::uint32_t>(Id::kConnect): return ParseAs<Connect, Id>(frame);
    case static_cast<std::uint32_t>(Id::kVacuum): return ParseAs<hand::Vacuum, Id>(frame);
    case static_cast<std::uint32_t>(Id::kDropOff): return ParseAs<hand::DropOff, Id>(frame);
    case static_cast<std::uint32_t>(Id::kStop): return ParseAs<hand::Stop, Id>(frame);
    default: break;
  }
  return BadFrame{fmt::format("command {} is none of the vacuum gripper's, which are 0 to {}",
                              frame.head.command, kVacuumCommands - 1)};
}

std::vector<std::byte> EncodeVacuumRequest(std::uint32_t command_id, const HandRequest& request) {
  return EncodeWith<VacuumNumbers>(command_id, request);
}

}  // namespace twin::fci
