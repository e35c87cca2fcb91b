#include "plugins/devices/evdev_sampler.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace twin::devices {
namespace {

double Centre(const AxisRange& range) {
  return 0.5 * (static_cast<double>(range.minimum) + static_cast<double>(range.maximum));
}

double Share(const AxisRange& range, double value) {
  const double half = 0.5 * (static_cast<double>(range.maximum) - range.minimum);
  const double beyond = std::abs(value - Centre(range)) - range.flat;
  if (!(beyond > 0 && half > range.flat)) return 0;
  return std::copysign(std::min(beyond / (half - range.flat), 1.0), value - Centre(range));
}

}  // namespace

EvdevSampler::EvdevSampler(const EvdevCapabilities& capabilities, EvdevProfile profile)
    : ranges_(capabilities.abs), profile_(std::move(profile)) {}

bool EvdevSampler::Take(const input_event& event, Time now) {
  switch (event.type) {
    case EV_ABS: absolute_[event.code] = event.value; return false;
    case EV_REL: relative_[event.code] = {event.value, now}; return false;
    case EV_KEY:  // 2 is auto-repeat and is ignored
      if (event.code < KEY_CNT && event.value != 2) TakeKey(event.code, event.value == 1, now);
      return false;
    default: return event.type == EV_SYN && event.code == SYN_REPORT;
  }
}

void EvdevSampler::TakeKey(std::uint16_t code, bool is_down, Time now) {
  if (down_[code] == is_down) return;
  down_[code] = is_down;
  if (profile_.two_buttons) {
    for (int button = 0; button < 2; ++button) {
      const bool is_it = (*profile_.two_buttons)[static_cast<std::size_t>(button)] == code;
      if (is_it) two_buttons_.Press(button, is_down, now, sample_);
    }
  }
  if (!is_down) return;
  for (const EvdevProfile::Key& key : profile_.keys) {
    if (key.code == code) ++(sample_.*key.presses);
  }
}

double EvdevSampler::Deflection(const AxisSource& source, Time now) const {
  if (source.kind == AxisSource::Kind::kAbsolute) {
    const auto value = absolute_.find(source.code);
    const auto range = ranges_.find(source.code);
    if (value == absolute_.end() || range == ranges_.end()) return 0;
    return source.sign * Share(range->second, value->second);
  }
  const auto value = relative_.find(source.code);
  const bool is_told = source.kind == AxisSource::Kind::kRelative && value != relative_.end() &&
                       now - value->second.at < kForget;
  return is_told ? source.sign * std::clamp(value->second.value / kFullRelative, -1.0, 1.0) : 0;
}

teleop::OperatorSample EvdevSampler::Sample(Time now, bool is_stopped) {
  two_buttons_.Pass(now, is_stopped, sample_);
  ++sample_.sequence;
  sample_.at = now;
  std::ranges::transform(profile_.axes, sample_.axes.begin(),
                         [&](const AxisSource& source) { return Deflection(source, now); });
  sample_.engaged = !(profile_.clutch && down_[*profile_.clutch]);
  return sample_;
}

void EvdevSampler::LetGo() {
  absolute_.clear();
  relative_.clear();
  down_.reset();
  two_buttons_.LetGo();
}

}  // namespace twin::devices
