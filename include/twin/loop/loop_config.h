#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "twin/control/controller.h"
#include "twin/core/limits.h"
#include "twin/core/time.h"
#include "twin/faults/delay_model.h"
#include "twin/reference/feed_forward.h"
#include "twin/reference/rate_limiter.h"
#include "twin/reference/viability_filter.h"

namespace twin::loop {

/// How the workstation's work is divided.
enum class LoopKind : std::uint8_t {
  kAsynchronous,  ///< the paper's: a communication thread paced by the robot, controllers beside it
  kSynchronous,   ///< the paper's RS: one periodic loop of read, controller, write, sleep
  kBare,          ///< the paper's LF: one loop paced by the robot, the controller inside
};

/// What stands between the deposited target and the command.
enum class Generator : std::uint8_t {
  kNone,       ///< the deposited value goes out as it is: a raw stream
  kJoint,      ///< the paper's joint reference generator
  kCartesian,  ///< its Cartesian counterpart
  kRejoining,  ///< deposits resampled by their source's time, rejoined by a saturated correction;
               ///< of positions, velocities or poses
};

/// @returns what a generator makes that does not go with the interface; empty when it does.
[[nodiscard]] std::string_view Misfit(Generator generator, control::CommandInterface interface);

/// The control tick's chain.
struct TickConfig {
  Generator generator = Generator::kJoint;
  double lambda = 1e-3;          ///< correction per cycle of the reference generator, in (0, 1]
  bool rate_matching = true;     ///< moving average over N = ceil(1000 / source rate) cycles
  double source_rate_hz = 1000;  ///< f_EXT, in [1, 1000]: the rate of the controller loop
  /// The finished command is sent once the target is at rest and every q_d is this close to it,
  /// rad (m and rad for poses).
  double finish_tolerance_rad = 1e-4;
  /// A cycle whose state came more than this off 1 ms after the last one is anomalous: nothing is
  /// written. Zero: every state is answered. The paper's rule has 250 us (its section on the
  /// asynchronous thread); it costs two commands for each late state and gains nothing that could
  /// be measured (src/reference/CHAINS.md), so it is off by default.
  Duration period_tolerance{};
  /// Without a deposit for so long, and at least three periods, the source counts as stalled:
  /// Generator::kRejoining then leads to the last target, behind the others its velocity (or
  /// torque) decays (reference::StallDecay). In [1 ms, 10 s].
  Duration stall_time = std::chrono::milliseconds(20);
  /// Cut-off of libfranka's first-order low-pass on the command, Hz, in [1, 1000]; 1000: off. On
  /// the incremental command of a reference generator it scales the increment: the robot follows a
  /// fraction of the motion.
  double low_pass_hz = 1000;
  /// libfranka's rate limiter on the command; absent: off.
  std::optional<reference::ClientLimits> limiter;
  /// Losses in a row under which the reference's limits are kept for ever, by a filter behind
  /// everything else: reference::ViabilityFilter on joint positions and velocities,
  /// reference::PoseViabilityFilter on poses; absent: off. Not on torques.
  std::optional<int> viability{};
  /// Of the robot's joints: what that filter, Generator::kRejoining and a stalled source's decay
  /// keep to. Zero, no limits: a stalled source's velocity stays.
  JointLimits limits{};
  /// Of its end effector, likewise.
  CartesianLimits cartesian{};
  faults::DelayModel
      cost;  ///< lockstep: time from the end of the read to the end of the write (d_EXT)

  /// @param interface  what the controller commands.
  /// @throws InputError naming field, value and range, or a generator or filter that does not go
  /// with the interface.
  void Validate(control::CommandInterface interface) const;
};

/// The periodic loop that runs the user's controller, on its own clock.
struct ControllerLoopConfig {
  double rate_hz = 1000;  ///< in [1, 1000]
  double clock_ppm = 0;   ///< how much faster this clock runs than the run's, in [-1000, 1000]
  Duration phase{};       ///< of its first wake-up against INT's grid, >= 0
  faults::DelayModel wake_delay;  ///< lockstep: how late it wakes after its deadline
  faults::DelayModel cost;        ///< lockstep: time from wake-up to deposit
  /// Which elapsed time forms the feed-forward velocity at the deposit.
  reference::FeedForwardTime feed_forward = reference::FeedForwardTime::kSource;
  /// Uniform noise added to every deposited value, in its unit: [-x, x]. What an unfiltered source
  /// looks like.
  double target_noise = 0;

  /// @throws InputError naming field, value and range.
  void Validate() const;
};

}  // namespace twin::loop
