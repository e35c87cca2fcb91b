#include "twin/robot/link_config.h"

#include <string_view>

#include <fmt/format.h>

#include "twin/core/error.h"

namespace twin::robot {
namespace {

void ValidateDirection(const DirectionConfig& direction, std::string_view where) {
  direction.Validate(where);
  if (direction.reorder_by <= kLongestOnTheWay) return;
  throw InputError(fmt::format(
      "{}.reorder_by is {} ms; it must lie in [0, {}] ms: what takes longer on the way is lost",
      where, ToSeconds(direction.reorder_by) * 1e3, ToSeconds(kLongestOnTheWay) * 1e3));
}

}  // namespace

void LinkConfig::Validate() const {
  ValidateDirection(state, "link.state");
  ValidateDirection(command, "link.command");
  if (d_INT < Duration::zero() || d_INT >= kCycle) {
    throw InputError(
        fmt::format("link.d_INT is {} us; it must lie in [0, 1000) us", ToSeconds(d_INT) * 1e6));
  }
}

}  // namespace twin::robot
