#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "twin/core/base_interface.h"
#include "twin/core/mobile_base.h"
#include "twin/core/realtime.h"
#include "twin/core/time.h"

namespace twin::onboard {

/// How fast a base's twist may change, magnitudes.
struct BaseAcceleration {
  double dv = 0;  ///< m/s^2, > 0
  double dw = 0;  ///< rad/s^2, > 0
  bool operator==(const BaseAcceleration&) const = default;
};

/// A base with four fixed wheels, two on a side, that turns by skidding.
struct BaseConfig {
  double wheel_radius = 0;  ///< R, m, > 0
  double track = 0;         ///< B, between the wheels' middles, m, > 0
  /// chi, >= 1: it turns as one with two wheels, chi B apart, that roll without slip.
  double track_factor = 1;
  BaseTwist most{};           ///< magnitudes; m/s, rad/s, > 0
  BaseAcceleration ordinary;  ///< when it follows commands
  BaseAcceleration lost;      ///< when it brakes because none has come
  BaseAcceleration emergency;
  double tau_max = 0;                                  ///< of each wheel, Nm, > 0
  Duration watchdog = std::chrono::milliseconds(200);  ///< > 0

  /// @throws InputError naming field, value and range.
  void Validate() const;
};

/// The controller of such a base: from a twist to torques on its wheels, at 1 kHz.
///
///   twist_d  moves to the command, cut to `most`, by at most `ordinary` in 1 ms
///   w_left, w_right = (v_d -+ w_d chi B / 2) / R                                     wheels'
///   speeds tau = Kp (w_d - w) + Ki integral (w_d - w), |tau| <= tau_max; the integral stops where
///   tau is cut odometry: v = R (w_left + w_right) / 2, w = R (w_right - w_left) / (chi B) of the
///   means of each side's turns, along an arc in each cycle
///
/// A command counts for `watchdog`; then twist_d goes to zero by at most `lost`. During an
/// emergency stop it does by `emergency`, and commands are dropped. Zero is held like any other
/// speed, so a base that stands does not roll away. Before the first command it stands. The
/// odometry begins at zero.
///
/// Gains: of a vehicle of 50 to 130 kg on wheels that roll or slide; our decision.
///
/// Threads: one thread. Real-time: Cycle() is noexcept and allocates nothing.
class BaseController {
 public:
  /// @param config  valid. @param sensors  of the wheels as they are found.
  BaseController(const BaseConfig& config, const WheelSensors& sensors) noexcept;

  /// @param command  that came since the last cycle; a part that is not finite counts as zero.
  /// @param emergency  whether an emergency stop holds.
  [[nodiscard]] WheelDrive Cycle(const WheelSensors& sensors,
                                 const std::optional<BaseTwist>& command,
                                 bool emergency) noexcept TWIN_REALTIME;

  /// As of the last cycle.
  [[nodiscard]] const BaseState& state() const noexcept { return state_; }

 private:
  using Wheels = std::array<double, 4>;

  void Take(const std::optional<BaseTwist>& command, bool emergency) noexcept;
  void MoveReference(bool emergency) noexcept;
  void Measure(const WheelSensors& sensors) noexcept;
  [[nodiscard]] WheelDrive Drive() noexcept;

  const BaseConfig config_;
  const double half_track_;  ///< chi B / 2, m
  BaseTwist command_;        ///< cut to the limits
  std::int64_t age_ = 0;     ///< of it, cycles
  bool commanded_ = false;   ///< one has come that counts
  Wheels q_last_{};
  Wheels integral_{};  ///< of the speeds' errors, rad
  BaseState state_;
};

}  // namespace twin::onboard
