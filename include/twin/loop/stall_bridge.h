#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "twin/control/controller.h"
#include "twin/core/realtime.h"
#include "twin/core/robot_command.h"
#include "twin/core/robot_state.h"
#include "twin/core/time.h"

namespace twin::loop {

/// Carries the chain over a source that stalls, or a robot that does, and back when it returns.
///
/// A target's velocity is the source's at its deposit. While no new deposit comes it is reused:
/// right for a cycle or two, wrong for ever. With N the cycles of the source's period,
/// - a deposit is late when more than N cycles went without one, or when its source time has gone
/// on
///   by more than N + 1/2 cycles above the robot's own (then it was the robot that stood still);
/// - after 2 N + 3 cycles without one the source counts as stalled: its velocity (or torque) is
/// zero,
///   so that the reference generator decays to the last target.
/// And when the robot took none of two or more commands in a row, its reference has gone its own
/// way. In all these cases what the chain demands would jump. Instead, for 2 N + 3 commands it
/// goes on from what the robot's reference does, v, at its own acceleration a, drawn to the demand
///   v'' = u^2 (demand - v) + 2 u (f - a),  u = 8 / |demand - v| within 6 and 20 1/s,
/// f the demand's own acceleration over 50 ms, at most 1 rad/s^2; and the difference e to the
/// demand is then taken away by a critically damped motion:
///   v = demand - e,  e'' + 2 w e' + w^2 e = 0,  w = 8 / |e| within 6 and 30 1/s,
/// e in w as it was when the robot's reference last went on; which costs at most 0.37 w e of
/// acceleration and w^2 e of jerk: 4.8 rad/s^2 for a joint's 2.175 rad/s. The small differences
/// that a held acceleration leaves are gone fast, before they have made a distance (2 e / w). What
/// e rises by is taken from a few commands, and is wrong when another lapse is near; so a lapse
/// within 48 cycles of the last one's end makes it go on for twice as many commands, at most 512:
/// behind a source that lapses for ever the drawn motion, which is stable, is all there is. It
/// lags: with 3 % of deposits up to 12 ms late the canonical trajectory is followed within 0.09
/// rad. A source in time is untouched, to the bit. The paper says that a stalled stream decays
/// gracefully; how is our decision.
///
/// A torque is inside a feedback loop, and a motion drawn to it would lag: behind lapses that recur
/// the loop would become unstable. It goes from what the robot drives with to the demand by at most
/// 500 Nm/s, half of what the robot takes, and is then the demand again; behind a stalled source it
/// decays by a tenth in 10 ms.
///
/// Threads: one. Real-time: noexcept, allocates nothing; O(cycles), at most 64.
class StallBridge {
 public:
  /// @param period_cycles  N, at least 1.
  StallBridge(control::CommandInterface interface, std::uint64_t period_cycles) noexcept;

  /// A motion begins.
  void Reset() noexcept;

  /// Before the chain's demand is formed.
  /// @param fresh   a deposit has come since the last call.
  /// @param cycles  of the robot since the last call, at least 1.
  /// @param source_time  of the newest deposit, on the source's own clock.
  /// @param unserved  cycles in a row in which the robot took no command.
  void Observe(bool fresh, std::uint64_t cycles, Time source_time,
               std::uint64_t unserved) noexcept TWIN_REALTIME;

  /// Whether the source counts as stalled.
  [[nodiscard]] bool stalled() const noexcept { return waited_ > 2 * period_cycles_ + 3; }
  /// Whether Carry() has anything to do.
  [[nodiscard]] bool active() const noexcept { return active_; }

  /// Whether so little is left of a lapse that the robot can stand still from it: at most 1e-4
  /// rad/s and 0.1 rad/s^2 (100 rad/s^3 when they are dropped in a cycle), or Nm and Nm/s.
  [[nodiscard]] bool settled() const noexcept;

  /// After the demand has been formed: puts what the bridge makes of it into `command`.
  /// @param state  that the command answers.
  void Carry(const RobotState& state, RobotCommand& command) noexcept TWIN_REALTIME;

 private:
  /// Seven joints (or torques); or three translations and three rotations.
  using Values = std::array<double, kJoints>;

  /// A difference on its way to zero.
  struct Difference {
    double x = 0;
    double rate = 0;
    double omega = 0;  ///< 1/s
    void Step() noexcept;
    [[nodiscard]] bool gone() const noexcept { return x == 0 && rate == 0; }
  };

  [[nodiscard]] bool IsLate(std::uint64_t cycles, Time source_time) const noexcept;
  /// @returns the value of axis `i` in the next cycle of the drawn motion.
  [[nodiscard]] double Drawn(std::size_t i, double demand, double last, double rate) const noexcept;
  /// @returns the w that is gentle on such a difference. @param largest  of a motion's.
  [[nodiscard]] static double OmegaOf(double difference, double largest) noexcept;
  /// @param last, rate  what the robot's reference does, and how that changes.
  void CarryValues(Values& demand, const Values& last, const Values& rate) noexcept;
  void CarryTorques(const JointVector& last, JointVector& demand) noexcept;

  control::CommandInterface interface_;
  std::uint64_t period_cycles_;

  std::uint64_t waited_ = 0;
  std::uint64_t cycles_ = 1;         ///< of the last Observe()
  std::uint64_t going_on_ = 0;       ///< commands for which the reference goes on
  std::uint64_t going_for_ = 0;      ///< what going_on_ began with
  std::uint64_t since_lapse_ = 0;    ///< cycles, of which many are all the same
  std::optional<Time> source_time_;  ///< of the last fresh deposit
  std::uint64_t since_first_ = 0;    ///< cycles since first_ was taken
  Values first_{};  ///< difference at the first of the commands its rise is taken over
  bool active_ = false;
  bool carrying_ = false;  ///< active_ at the end of the last Carry()
  Values slow_{};          ///< demand, low-passed
  std::array<Difference, kJoints> difference_{};
};

}  // namespace twin::loop
