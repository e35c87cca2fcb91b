#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "twin/core/hand_command.h"
#include "twin/core/hand_interface.h"
#include "twin/core/realtime.h"

namespace twin::onboard {

/// The hand's own controller: homing, moves, grasps, and what is reported of them. It runs beside
/// the arm's: no mode, reflex or user stop of the arm stops it.
///
/// While the fingers move, a finger's position x = width / 2 follows a reference that advances at
/// the commanded speed:
///   f = K (x_d - x) + D (dx_d - dx),   cut to the motion's force (a grasp's own, else 30 N).
/// It has met something (contact) when for 20 cycles it presses with at least 5 N, or half of what
/// it may, and hardly moves. A grasp then presses with its force F, risen to within 0.1 s, less
/// what keeps the drive from racing when the object goes:
///   f = F min(1, 1 - dx / v_top),   dx towards the object,
/// and once the fingers have stood still for 50 cycles it succeeds when
///   width - epsilon_inner < opening < width + epsilon_outer,
/// and is unsuccessful otherwise; it goes on pressing either way, until the next command.
///
/// is_grasped is what that law says at every cycle while a grasp presses: the opening is inside the
/// band, the fingers have stood still for 20 cycles and press with at least half of F. So it turns
/// false when the object is lost or released; and a band that includes zero is satisfied by fingers
/// that have closed on nothing, as on the robot.
///
/// Homing closes and opens; the opening at the upper stop is max_width. Temperature follows
///   300 s dT/dt = 25 + 25 (f / 70 N)^2 - T   (degrees Celsius).
///
/// Decisions, where the real hand is odd or its ways are not public: a command that comes while
/// another runs aborts that one, also a Grasp during or after a Grasp; a Move that is stopped by
/// something fails after 0.5 s and relaxes (the real hand blocks for minutes); homing fails when
/// something lies between the fingers, and then leaves max_width as it was; Stop always works,
/// and leaves the fingers where they are without pressing; Move and Grasp work before homing,
/// with the opening the hand is built for; a speed above 0.1 m/s means 0.1 m/s; a Grasp of a width
/// that the fingers are inside of by more than epsilon_inner opens, and grasps from within.
/// Gains, thresholds and temperature law are ours. Source of the rest: FCI protocol 5, gripper.
///
/// Threads: one. Real-time: all calls are noexcept, O(1), allocate nothing.
class Gripper {
 public:
  /// @param sensors  as the hand is switched on: it holds this opening until told otherwise.
  explicit Gripper(const HandSensors& sensors) noexcept;

  /// Starts a command; it takes effect in the next Cycle(). Stop ends at once. A command with a
  /// bad value is refused, and what runs goes on.
  HandStart Start(const HandCommand& command) noexcept TWIN_REALTIME;

  /// @returns how the command ended; nothing while it runs, and of a ticket never given. The
  /// results of the last kRemembered commands are kept; earlier ones count as aborted.
  [[nodiscard]] std::optional<HandResult> Outcome(HandTicket ticket) const noexcept TWIN_REALTIME;

  /// One cycle of 1 ms. @param sensors  after the last one.
  [[nodiscard]] HandDrive Cycle(const HandSensors& sensors) noexcept TWIN_REALTIME;

  /// As of the last Cycle().
  [[nodiscard]] const HandState& state() const noexcept { return state_; }

  static constexpr std::size_t kRemembered = 8;

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
  /// Begins a motion of the reference from where the fingers are.
  void BeginMotion(Phase phase, double target, double speed, double force) noexcept;
  void End(HandResult result) noexcept;
  /// Lets go, and then holds the opening as it is.
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
  double target_ = 0;       ///< what it moves to
  double speed_ = 0;        ///< of the reference, m/s
  double force_limit_ = 0;  ///< of the motion, N
  double direction_ = 1;    ///< of the motion: 1 opens
  double pressed_ = 0;      ///< the force of a grasp, so far
  int slow_cycles_ = 0;     ///< for how long the fingers have hardly moved, for the motion's speed
  int contact_cycles_ = 0;  ///< for how long they have pressed on something beside that
  int still_cycles_ = 0;    ///< for how long they have stood still
  int phase_cycles_ = 0;    ///< since the phase began
  double temperature_ = 0;

  struct Entry {
    HandTicket ticket = 0;
    std::optional<HandResult> result;
  };
  std::array<Entry, kRemembered> entries_{};
  HandTicket last_ticket_ = 0;
  HandTicket running_ = 0;  ///< zero: none
};

}  // namespace twin::onboard
