#include "plugins/devices/two_buttons.h"

namespace twin::devices {
namespace {

using teleop::OperatorSample;

constexpr std::array kShort{&OperatorSample::gripper_presses, &OperatorSample::mode_presses};
constexpr std::array kLong{&OperatorSample::release_presses, &OperatorSample::end_presses};

}  // namespace

void TwoButtons::Press(int button, bool is_down, Time now, OperatorSample& sample) noexcept {
  const auto mine = static_cast<std::size_t>(button);
  std::optional<Down>& me = down_[mine];
  std::optional<Down>& other = down_[1 - mine];
  if (is_down == me.has_value()) return;
  if (!is_down) {
    if (!me->is_used) ++(sample.*kShort[mine]);
    me.reset();
    return;
  }
  me = Down{now, other.has_value()};
  if (!other) return;
  ++sample.stop_presses;
  other->is_used = true;
}

void TwoButtons::Pass(Time now, bool is_stopped, OperatorSample& sample) noexcept {
  for (std::size_t i = 0; i < down_.size(); ++i) {
    std::optional<Down>& down = down_[i];
    const bool is_held = down && !down->is_used && now - down->since >= kHold;
    if (!is_held || !is_stopped) continue;
    ++(sample.*kLong[i]);
    down->is_used = true;
  }
}

}  // namespace twin::devices
