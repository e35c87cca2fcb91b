#include <fmt/format.h>

#include "fci/device_requests.h"
#include "twin/core/error.h"

namespace twin::fci {
namespace {

struct HandNumbers {
  HandCommandId operator()(const Connect&) { return HandCommandId::kConnect; }
  HandCommandId operator()(const hand::Homing&) { return HandCommandId::kHoming; }
  HandCommandId operator()(const hand::Grasp&) { return HandCommandId::kGrasp; }
  HandCommandId operator()(const hand::Move&) { return HandCommandId::kMove; }
  HandCommandId operator()(const hand::Stop&) { return HandCommandId::kStop; }
  /// The vacuum gripper's.
  HandCommandId operator()(const auto&) {
    TWIN_CHECK(false);
    return {};
  }
};

}  // namespace

std::variant<HandRequest, BadFrame> ParseHandRequest(const Frame& frame) {
  // The hand's head has a 16-bit command; a larger one cannot come from a stream.
  using Id = HandCommandId;
  switch (frame.head.command) {
    case static_cast<std::uint32_t>(Id::kConnect): return ParseAs<Connect, Id>(frame);
    case static_cast<std::uint32_t>(Id::kHoming): return ParseAs<hand::Homing, Id>(frame);
    case static_cast<std::uint32_t>(Id::kGrasp): return ParseAs<hand::Grasp, Id>(frame);
    case static_cast<std::uint32_t>(Id::kMove): return ParseAs<hand::Move, Id>(frame);
    case static_cast<std::uint32_t>(Id::kStop): return ParseAs<hand::Stop, Id>(frame);
    default: break;
  }
  return BadFrame{fmt::format("command {} is none of the hand's, which are 0 to {}",
                              frame.head.command, kHandCommands - 1)};
}

std::vector<std::byte> EncodeRequest(std::uint32_t command_id, const HandRequest& request) {
  return EncodeWith<HandNumbers>(command_id, request);
}

}  // namespace twin::fci
