#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "twin/core/body_interface.h"
#include "twin/core/hand_command.h"
#include "twin/core/realtime.h"
#include "twin/onboard/hand_outcomes.h"

namespace twin::onboard {

/// Controller of the hand: homing, moves, grasps and their results. It runs beside the arm's: no
/// mode, reflex or user stop of the arm stops it.
///
/// While the fingers move, a finger's position x = width / 2 follows a reference that advances at
/// the commanded speed:
///   f = K (x_d - x) + D (dx_d - dx),   cut to the motion's force (a grasp's own, else 30 N).
/// The fingers are in contact when for 20 cycles they press with at least 5 N, or half of the force
/// limit, and hardly move. A grasp then presses with its force F, ramped up within 0.1 s and
/// reduced with the speed to keep the drive from racing when the object slips out:
///   f = F min(1, 1 - dx / v_top),   dx towards the object.
/// Once the fingers have been at rest for 50 cycles, the grasp succeeds if
///   width - epsilon_inner < opening < width + epsilon_outer,
/// and is unsuccessful otherwise; in both cases it presses until the next command.
///
/// is_grasped is evaluated in every cycle while a grasp presses: the opening is inside the band,
/// and the fingers have been at rest for 20 cycles and press with at least half of F. So it becomes
/// false when the object is lost or released. A band that includes zero also holds for fingers that
/// have closed without an object, as on the robot.
///
/// Homing closes and opens; the opening at the upper stop is max_width. Temperature follows
///   300 s dT/dt = 25 + 25 (f / 70 N)^2 - T   (degrees Celsius).
///
/// Decisions, where the real hand is inconsistent or its behaviour is not public: a command aborts
/// the running one, also a Grasp during or after a Grasp; a Move that an obstacle stops fails after
/// 0.5 s and relaxes (the real hand blocks for minutes); homing fails with an object between the
/// fingers and then keeps max_width; Stop always works and leaves the fingers in place without
/// pressing; Move and Grasp work before homing, with the hand's nominal opening; a speed above 0.1
/// m/s means 0.1 m/s; a Grasp of a width that exceeds the opening by more than epsilon_inner opens
/// and grasps from within. Gains, thresholds and temperature law are ours. Source of the rest: FCI
/// protocol 5, gripper.
///
/// Threads: one. Real-time: all calls are noexcept, O(1), allocate nothing.
class Gripper {
 public:
  /// @param sensors  at power-on; the hand holds this opening until the first command.
  explicit Gripper(const HandSensors& sensors) noexcept;

  /// Starts a command; it takes effect in the next Cycle(). Stop ends at once. A command with an
  /// invalid value is refused, and the running one continues.
  HandStart Start(const HandCommand& command) noexcept TWIN_REALTIME;

  /// As HandOutcomes.
  [[nodiscard]] std::optional<HandResult> Outcome(HandTicket ticket) const noexcept TWIN_REALTIME {
    return outcomes_.Of(ticket);
  }

  /// Advances by 1 ms. @param sensors  after the last cycle.
  [[nodiscard]] HandDrive Cycle(const HandSensors& sensors) noexcept TWIN_REALTIME;

  /// As of the last Cycle().
  [[nodiscard]] const HandState& state() const noexcept { return state_; }

  static constexpr std::size_t kRemembered = HandOutcomes::kRemembered;

 private:
  enum class Phase : std::uint8_t {
    kHolding,      ///< the opening, without pressing
    kMoving,       ///< to target_
    kApproaching,  ///< a grasp, until contact
    kPressing,     ///< a grasp in contact, or one that has ended
    kClosing,      ///< homing, to the lower stop
    kOpening,      ///< homing, to the upper stop
  };

  void Take(const hand::Homing& homing) noexcept;
  void Take(const hand::Move& move) noexcept;
  void Take(const hand::Grasp& grasp) noexcept;
  void Take(const hand::Stop& stop) noexcept;
  void Take(const hand::Vacuum& /*none*/) noexcept {}  // refused: the pump's
  void Take(const hand::DropOff& /*none*/) noexcept {}
  /// Starts a motion of the reference at the fingers' position.
  void BeginMotion(Phase phase, double target, double speed, double force) noexcept;
  void End(HandResult result) noexcept { outcomes_.End(result); }
  /// Releases the force, then holds the current opening.
  void Relax() noexcept;

  void Count() noexcept;
  void Advance() noexcept;
  void AdvanceMove() noexcept;
  void AdvanceHoming() noexcept;
  void AdvancePressing() noexcept;
  [[nodiscard]] bool InContact() const noexcept { return contact_cycles_ >= kContactCycles; }
  [[nodiscard]] bool Grasped() const noexcept;
  [[nodiscard]] bool InsideBand() const noexcept;
  [[nodiscard]] HandDrive Drive() noexcept;
  [[nodiscard]] HandDrive Servo() noexcept;
  [[nodiscard]] HandDrive Press() noexcept;
  void Report(double force) noexcept;

  static constexpr int kContactCycles = 20;

  HandSensors sensors_;
  HandState state_;
  Phase phase_ = Phase::kHolding;
  hand::Grasp grasp_;
  double width_d_ = 0;      ///< the reference
  double target_ = 0;       ///< target of the reference
  double speed_ = 0;        ///< of the reference, m/s
  double force_limit_ = 0;  ///< of the motion, N
  double direction_ = 1;    ///< of the motion: 1 opens
  double pressed_ = 0;      ///< current force of a grasp
  int slow_cycles_ = 0;     ///< cycles at a low speed, relative to the motion's
  int contact_cycles_ = 0;  ///< those while also pressing
  int still_cycles_ = 0;    ///< cycles at rest
  int phase_cycles_ = 0;    ///< cycles since the phase began
  double temperature_ = 0;
  HandOutcomes outcomes_;
};

}  // namespace twin::onboard
