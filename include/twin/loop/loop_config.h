#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "twin/control/controller.h"
#include "twin/core/limits.h"
#include "twin/core/time.h"
#include "twin/faults/delay_model.h"
#include "twin/model/lab_limits.h"
#include "twin/reference/feed_forward.h"
#include "twin/reference/rate_limiter.h"
#include "twin/reference/viability_filter.h"

namespace twin::loop {

/// Structure of the workstation's loop.
enum class LoopKind : std::uint8_t {
  kAsynchronous,  ///< the paper's: a communication thread paced by the robot, controllers beside it
  kSynchronous,   ///< the paper's RS: one periodic loop of read, controller, write, sleep
  kBare,          ///< the paper's LF: one loop paced by the robot, with the controller inside
};

/// Stage between the deposited target and the command.
enum class Generator : std::uint8_t {
  kNone,       ///< sends the deposited value unchanged: a raw stream
  kJoint,      ///< the paper's joint reference generator
  kCartesian,  ///< its Cartesian counterpart
  kRejoining,  ///< resamples deposits by their source's time and rejoins them by a saturated
               ///< correction; for positions, velocities or poses
};

/// @returns a text about the generator's output if it does not fit the interface; else empty.
[[nodiscard]] std::string_view Misfit(Generator generator, control::CommandInterface interface);

/// Configuration of the control tick and its command chain.
struct TickConfig {
  Generator generator = Generator::kJoint;
  double lambda = 1e-3;          ///< correction per cycle of the reference generator, in (0, 1]
  bool rate_matching = true;     ///< moving average over N = ceil(1000 / source rate) cycles
  double source_rate_hz = 1000;  ///< f_EXT, in [1, 1000]: rate of the controller loop
  /// The tick sends the finished command once the target is at rest and every q_d is this close to
  /// it, rad (m and rad for poses).
  double finish_tolerance_rad = 1e-4;
  /// Largest deviation from 1 ms of the time between two states; in a cycle beyond it, the tick
  /// writes nothing. Zero: every state is answered. The paper uses 250 us (its section on the
  /// asynchronous thread). This rule costs two commands per late state without a measurable benefit
  /// (src/reference/CHAINS.md), so it is off by default.
  Duration period_tolerance{};
  /// The source counts as stalled after this time, and at least three periods, without a deposit.
  /// Generator::kRejoining then leads to the last target; with the others, the target's velocity
  /// (or torque) decays (reference::StallDecay). In [1 ms, 10 s].
  Duration stall_time = std::chrono::milliseconds(20);
  /// Cut-off of libfranka's first-order low-pass on the command, Hz, in [1, 1000]; 1000: off. On
  /// the incremental command of a reference generator it scales the increment: the robot follows a
  /// fraction of the motion. Refused behind Generator::kRejoining.
  double low_pass_hz = 1000;
  /// libfranka's rate limiter on the command; absent: off.
  std::optional<reference::ClientLimits> limiter;
  /// Number of successive losses under which the last stage keeps the reference within its limits:
  /// reference::ViabilityFilter on joint positions and velocities, reference::PoseViabilityFilter
  /// on poses; absent: off. Not available on torques.
  std::optional<int> viability{};
  /// Joint limits for the viability filter, Generator::kRejoining, the proof of stops and the decay
  /// of a stalled source. Zero means no limits: the velocity of a stalled source stays.
  JointLimits limits{};
  /// Likewise, for the end effector.
  CartesianLimits cartesian{};
  /// Limits of a lab: before a command goes out, the tick proves that the arm can still stop within
  /// them, else it stops the arm and ends the motion (src/loop/limit_guard.h); absent: none.
  std::optional<model::LabLimits> lab{};
  bool lab_hand = true;  ///< a Franka Hand is mounted, which the regions limit
  faults::DelayModel
      cost;  ///< lockstep: time from the end of the read to the end of the write (d_EXT)

  /// @param interface  the controller's.
  /// @throws InputError naming field, value and range, or a generator or filter that does not fit
  /// the interface.
  void Validate(control::CommandInterface interface) const;
};

/// The periodic loop that runs the user's controller, on its own clock.
struct ControllerLoopConfig {
  double rate_hz = 1000;  ///< in [1, 1000]
  double clock_ppm = 0;   ///< rate of this clock relative to the run's, minus 1; in [-1000, 1000]
  Duration phase{};       ///< of its first wake-up relative to INT's grid, >= 0
  faults::DelayModel wake_delay;  ///< lockstep: lateness of wake-ups
  faults::DelayModel cost;        ///< lockstep: time from wake-up to deposit
  /// Elapsed time used for the feed-forward velocity at the deposit.
  reference::FeedForwardTime feed_forward = reference::FeedForwardTime::kSource;
  /// Amplitude x of uniform noise in [-x, x], added to every deposited value, in its unit; models
  /// an unfiltered source.
  double target_noise = 0;

  /// @throws InputError naming field, value and range.
  void Validate() const;
};

}  // namespace twin::loop
