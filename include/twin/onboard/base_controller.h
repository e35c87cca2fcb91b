#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "twin/core/body_interface.h"
#include "twin/core/mobile_base.h"
#include "twin/core/realtime.h"
#include "twin/core/time.h"

namespace twin::onboard {

/// Largest rate of change of a base's twist, magnitudes.
struct BaseAcceleration {
  double dv = 0;  ///< m/s^2, > 0
  double dw = 0;  ///< rad/s^2, > 0
  bool operator==(const BaseAcceleration&) const = default;
};

/// A skid-steered base with four fixed wheels, two on each side.
struct BaseConfig {
  double wheel_radius = 0;  ///< R, m, > 0
  double track = 0;         ///< B, between the wheels' centre planes, m, > 0
  /// chi, >= 1: the base turns like two wheels, chi B apart, that roll without slip.
  double track_factor = 1;
  BaseTwist most{};           ///< magnitudes; m/s, rad/s, > 0
  BaseAcceleration ordinary;  ///< while it follows commands
  BaseAcceleration lost;      ///< while it brakes after the watchdog has expired
  BaseAcceleration emergency;
  double tau_max = 0;                                  ///< per wheel, Nm, > 0
  Duration watchdog = std::chrono::milliseconds(200);  ///< > 0

  /// @throws InputError naming field, value and range.
  void Validate() const;
};

/// Controller of a skid-steered base: from a twist to wheel torques, at 1 kHz.
///
///   twist_d         follows the command, cut to `most`, by at most `ordinary` T in T = 1 ms
///   w_left, w_right = (v_d -+ w_d chi B / 2) / R
///   tau             = Kp (w_d - w) + Ki integral (w_d - w), |tau| <= tau_max, no windup while cut
///   odometry        v = R (w_left + w_right) / 2, w = R (w_right - w_left) / (chi B), from each
///                   side's mean rotation, along an arc in each cycle
///
/// A command is valid for `watchdog`; then twist_d ramps to zero by `lost`. During an emergency
/// stop it ramps to zero by `emergency`, and commands are dropped. The controller also regulates
/// zero speed, so a base at rest does not roll away. It commands zero before the first command. The
/// odometry starts at zero.
///
/// Gains suit a vehicle of 50 to 130 kg on wheels that roll or slide; they are decisions.
///
/// Threads: one thread. Real-time: Cycle() is noexcept and allocates nothing.
class BaseController {
 public:
  /// @param config  valid. @param sensors  wheel sensors at start.
  BaseController(const BaseConfig& config, const WheelSensors& sensors) noexcept;

  /// @param command  arrived since the last cycle; a component that is not finite counts as zero.
  /// @param emergency  whether an emergency stop is active.
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

  BaseConfig config_;
  double half_track_;       ///< chi B / 2, m
  BaseTwist command_;       ///< cut to the limits
  std::int64_t age_ = 0;    ///< of command_, cycles
  bool commanded_ = false;  ///< command_ is valid
  Wheels q_last_{};
  Wheels integral_{};  ///< of the speed errors, rad
  BaseState state_;
};

}  // namespace twin::onboard
