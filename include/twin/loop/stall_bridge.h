#pragma once

#include <array>
#include <cstdint>

#include "twin/control/controller.h"
#include "twin/core/realtime.h"
#include "twin/reference/target.h"

namespace twin::loop {

/// Carries the chain over a source that stalls, and back when it returns.
///
/// A target's velocity is the source's at its deposit. While no new deposit comes it is reused,
/// which is right for a cycle or two and wrong for ever. With N the cycles of the source's period:
/// - a deposit that comes after more than N cycles without one is late;
/// - after 2 N + 3 cycles the source counts as stalled, and its velocity as zero, so that the
/// reference
///   generator decays to the last target.
/// Neither that nor the late source's return, further on by now, may be a step: jumps of velocity
/// and of position are absorbed into offsets which a critically damped motion takes away,
///   x'' + 2 w x' + w^2 x = 0,  w = 6 1/s,
/// so that a jump v costs at most 0.37 w v of acceleration (4.8 rad/s^2 at a joint's
/// 2.175 rad/s) and w^2 v of jerk. While a source is in time, and once the offsets are gone,
/// targets pass unchanged to the bit.
///
/// On the velocity and torque interfaces a stalled source decays to zero velocity or torque (the
/// robot compensates gravity). For poses the rotation's offset is a rotation vector in base axes.
/// The decision to bridge, and w, are ours; the paper says that a stalled stream decays gracefully.
///
/// Threads: one. Real-time: Next() is noexcept, O(1), allocates nothing.
class StallBridge {
 public:
  /// @param period_cycles  N, at least 1.
  StallBridge(control::CommandInterface interface, std::uint64_t period_cycles) noexcept
      : interface_(interface), period_cycles_(period_cycles) {}

  /// A motion begins.
  void Reset() noexcept;

  /// @param target  newest, rate-matched. @param fresh  a deposit has come since the last call.
  /// @param cycles  of the robot since the last call, at least 1.
  [[nodiscard]] reference::Target Next(const reference::Target& target, bool fresh,
                                       std::uint64_t cycles) noexcept TWIN_REALTIME;

  /// Whether the source counts as stalled.
  [[nodiscard]] bool stalled() const noexcept { return waited_ > 2 * period_cycles_ + 3; }
  /// Whether offsets of a stall are still being taken away.
  [[nodiscard]] bool active() const noexcept { return active_; }

 private:
  /// An offset on its way to zero.
  struct Offset {
    double x = 0;
    double rate = 0;
    void Step() noexcept;
    [[nodiscard]] bool gone() const noexcept { return x == 0 && rate == 0; }
  };
  /// What is carried: seven joints (or torques); or three translations and three rotations.
  using Values = std::array<double, kJoints>;

  struct Motion {
    Values velocity{};
    Values step{};  ///< of the position since the last target
  };

  [[nodiscard]] Motion MotionOf(const reference::Target& target) const noexcept;
  [[nodiscard]] reference::Target Carried(reference::Target target,
                                          const Values& velocity) const noexcept;
  void Bridge(Motion& motion, bool turns) noexcept;

  control::CommandInterface interface_;
  std::uint64_t period_cycles_;
  std::uint64_t waited_ = 0;
  bool active_ = false;
  Values last_velocity_{};
  reference::Target last_;
  std::array<Offset, kJoints> velocity_offset_{};
  std::array<Offset, kJoints> position_offset_{};
};

}  // namespace twin::loop
