#pragma once

#include <linux/input.h>

#include <array>
#include <bitset>
#include <cstdint>
#include <map>

#include "plugins/devices/evdev_profile.h"
#include "plugins/devices/two_buttons.h"
#include "twin/core/time.h"
#include "twin/teleop/operator_sample.h"

namespace twin::devices {

/// Converts a device's events to samples.
///
/// An absolute axis with range [a, b] and flat f gives, with c = (a + b)/2 and h = (b - a)/2,
///   sign(v - c) max(0, |v - c| - f)/(h - f), cut to [-1, 1].
/// A relative axis reports the position of a SpaceMouse's cap, up to kFullRelative. It sends no
/// event when released: kForget after the last event it counts as centred. (While held, the device
/// reports every 8 to 16 ms.)
///
/// Threads: one. Not for real time.
class EvdevSampler {
 public:
  static constexpr double kFullRelative = 350;
  static constexpr Duration kForget = std::chrono::milliseconds(60);

  EvdevSampler(const EvdevCapabilities& capabilities, EvdevProfile profile);

  /// @returns true if the events so far form a complete report.
  bool Take(const input_event& event, Time now);

  /// The current sample, with the next sequence. @param is_stopped  as reported by the robot.
  [[nodiscard]] teleop::OperatorSample Sample(Time now, bool is_stopped);

  /// The device was unplugged: releases all keys, centres all axes, adds no presses.
  void LetGo();

 private:
  struct Relative {
    int value = 0;
    Time at{};
  };
  [[nodiscard]] double Deflection(const AxisSource& source, Time now) const;
  void TakeKey(std::uint16_t code, bool is_down, Time now);

  const std::map<std::uint16_t, AxisRange> ranges_;
  const EvdevProfile profile_;
  std::map<std::uint16_t, int> absolute_;
  std::map<std::uint16_t, Relative> relative_;
  std::bitset<KEY_CNT> down_;
  TwoButtons two_buttons_;
  teleop::OperatorSample sample_;
};

}  // namespace twin::devices
