#pragma once

#include <cstdint>
#include <optional>

#include "twin/core/body_interface.h"
#include "twin/core/hand_command.h"
#include "twin/core/realtime.h"
#include "twin/onboard/hand_outcomes.h"

namespace twin::onboard {

/// Controller of the vacuum gripper (cobot pump): suction, drop-off and their results. It runs
/// beside the arm's: no mode, reflex or user stop of the arm stops it.
///
/// Vacuum closes the valve and pumps to the set point H1 = 10 mbar times the command's, at most 750
/// mbar, what the pump reaches. The power is regulated by the vacuum p that is measured:
///   power = (H1 - p) / 75 mbar, cut to [0, 1].
/// The flags follow p (mbar):
///   part_present      above H2 = 11/15 H1, until below H2 - 10
///   in_control_range  |p - H1| <= H1 / 10 while it sucks
///   part_detached     once p is below 50 after a part was present, until the next Vacuum
/// Vacuum succeeds as soon as a part is present, and it goes on sucking until the next command. It
/// is unsuccessful if there is none within its timeout, and then ends the suction. DropOff stops
/// the pump and opens the valve; it succeeds once p is below 50, and is unsuccessful if that takes
/// longer than its timeout (the valve stays open). Stop ends the running command and the suction,
/// as DropOff does, and is a success at once.
///
/// device_status is yellow after a Vacuum that was unsuccessful, and once a part was lost that
/// nobody dropped, until the next command that succeeds; else green. is_grasped is part_present.
///
/// Decisions, since the real device is documented by one line for each command and flag: all of the
/// above but the units. Its manufacturer's factory settings H1 = 750, H2 = 550 and h2 = 10 mbar
/// (Schmalz, compact terminals and ejectors) are behind H2; the four profiles, which hold a user's
/// settings, are all these. A command aborts the running one. Orange and red never show. Source of
/// the rest: FCI protocol 5, vacuum gripper.
///
/// Threads: one. Real-time: all calls are noexcept, O(1), allocate nothing.
class VacuumPump {
 public:
  /// @param sensors  at power-on; the pump rests and the valve is open until the first command.
  explicit VacuumPump(const PumpSensors& sensors) noexcept;

  /// Starts a command; it takes effect in the next Cycle(). Stop ends at once. A command with an
  /// invalid value is refused, and the running one continues.
  HandStart Start(const HandCommand& command) noexcept TWIN_REALTIME;

  /// As HandOutcomes.
  [[nodiscard]] std::optional<HandResult> Outcome(HandTicket ticket) const noexcept TWIN_REALTIME {
    return outcomes_.Of(ticket);
  }

  /// Advances by 1 ms. @param sensors  after the last cycle.
  [[nodiscard]] PumpDrive Cycle(const PumpSensors& sensors) noexcept TWIN_REALTIME;

  /// As of the last Cycle(), with its `pump`.
  [[nodiscard]] const HandState& state() const noexcept { return state_; }

 private:
  void Take(const hand::Vacuum& vacuum) noexcept;
  void Take(const hand::DropOff& drop) noexcept;
  void Take(const hand::Stop& stop) noexcept;
  void Take(const hand::Homing& /*none*/) noexcept {}  // refused: the fingers'
  void Take(const hand::Move& /*none*/) noexcept {}
  void Take(const hand::Grasp& /*none*/) noexcept {}

  /// Flags of the vacuum that is measured.
  void Observe(double vacuum_mbar) noexcept;
  void Advance() noexcept;
  void End(HandResult result) noexcept;
  void Report() noexcept;

  HandState state_;
  VacuumState pump_;  ///< copied into state_ at the end of a cycle
  HandOutcomes outcomes_;
  bool sucks_ = false;
  double set_point_ = 0;          ///< H1, mbar
  std::int64_t cycles_left_ = 0;  ///< until the running command's timeout
  bool held_ = false;             ///< a part was present since the last Vacuum began
};

}  // namespace twin::onboard
