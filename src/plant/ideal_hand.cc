#include "twin/plant/ideal_hand.h"

#include <algorithm>

#include "twin/core/hand_command.h"
#include "twin/core/time.h"

namespace twin::plant {

void IdealHand::Reset() noexcept {
  sensors_ = {.width = kHandStroke, .dwidth = 0, .force = 0};
  drive_ = {.force = 0, .width_d = kHandStroke};
}

void IdealHand::Step() noexcept {
  const double width = std::clamp(drive_.width_d, 0.0, kHandStroke);
  const bool at_stop =
      (width == 0 && drive_.force < 0) || (width == kHandStroke && drive_.force > 0);
  sensors_.dwidth = (width - sensors_.width) / kCycleSeconds;
  sensors_.width = width;
  sensors_.force = at_stop ? drive_.force : 0;
}

}  // namespace twin::plant
