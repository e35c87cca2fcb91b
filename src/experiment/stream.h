#pragma once

#include <cstdint>
#include <functional>
#include <optional>

#include "twin/control/controller.h"
#include "twin/core/joint_vector.h"
#include "twin/core/limits.h"
#include "twin/core/time.h"
#include "twin/experiment/experiment.h"
#include "twin/loop/loop_config.h"
#include "twin/onboard/joint_reference.h"
#include "twin/reference/target.h"
#include "twin/reference/trajectory.h"
#include "twin/scenario/robot_data.h"

namespace twin::experiment {

/// Source of a deposited position's velocity.
enum class VelocityFrom : std::uint8_t {
  kGiven,        ///< given by the source
  kSourceTime,   ///< difference of two deposits over the source's own elapsed time
  kNominalTime,  ///< the same over the nominal period
  kConsumption,  ///< difference of two consumed positions over the robot's cycle
};

/// A source that samples a planned trajectory with a clock of its own, and the stages between its
/// deposits and the robot. Deposit i is sampled at i P + dt(i) of the source's clock and deposited
/// at once; the robot's cycles at k T consume the newest deposit. The link takes no time and loses
/// nothing.
struct Stream {
  /// Command chain; source_rate_hz is the source's.
  loop::TickConfig tick{.generator = loop::Generator::kNone, .limiter = {}, .cost = {}};
  control::CommandInterface interface = control::CommandInterface::kJointPosition;
  VelocityFrom velocity = VelocityFrom::kSourceTime;
  /// Sampled once per cycle at the robot's own time (message_id), not by a clock.
  bool on_robot_time = false;
  double jitter_s = 0;          ///< of dt, normal: standard deviation
  double noise = 0;             ///< uniform in [-x, x] on every deposited position, rad
  double clock_ppm = 0;         ///< how much faster the source's clock runs than the robot's
  Duration phase = kCycle / 2;  ///< of deposit 0 after a cycle of the robot, in [0, T)
  std::uint64_t seed = 1;
};

/// dt(i) of a stream, in whole nanoseconds. Thread-safe.
[[nodiscard]] Duration SamplingError(const Stream& stream, std::uint64_t deposit) noexcept;

/// One cycle of the robot.
struct StreamCycle {
  std::uint64_t cycle = 0;               ///< k; the first with a deposit is not always 0
  const onboard::JointReference& next;   ///< INT's reference after the command
  const reference::JointTarget& target;  ///< the consumed deposit
};

/// Result of a stream.
struct StreamResult {
  std::uint64_t cycles = 0;                ///< with a command
  std::optional<std::uint64_t> aborted{};  ///< first cycle that INT refuses
  JointVector jerk{};                      ///< largest, as a share of its limit
  JointVector rms_jerk{};                  ///< root of the mean square, the same
  /// Largest share of a limit of velocity, acceleration or jerk: above 1 the joint alone aborts.
  JointVector share{};
};

/// Feeds a stream to INT on an ideal plant: the command chain as the tick runs it
/// (loop::CommandChain), INT's backward differences (onboard::JointReference) and its checks
/// (onboard::CheckStep); from rest at the trajectory's start to 20 cycles after its end.
///
/// Threads: any. @param stops  ends at the first refused command, as the robot does; else the robot
/// takes it all the same, so that the result covers the whole stream. @param tell  receives each
/// cycle; may be empty. @throws InputError as TickConfig::Validate.
[[nodiscard]] StreamResult RunStream(const reference::Trajectory& plan, const JointLimits& limits,
                                     const Stream& stream, bool stops,
                                     const std::function<void(const StreamCycle&)>& tell = {});

/// The Panda, and the motion of the experiments on streams.
struct StreamInputs {
  scenario::RobotData robot;
  reference::Trajectory canonical;  ///< of the calibrated asynchronous loop
};
/// @throws InputError as Load.
[[nodiscard]] StreamInputs LoadStreamInputs(const Config& config);

/// The stages between a disturbed source and the robot.
enum class Remedy : std::uint8_t {
  kNone,           ///< the sampled positions go out unchanged
  kLimiter,        ///< libfranka's rate limiter
  kLowPass,        ///< libfranka's low-pass, 100 Hz
  kRobotTime,      ///< sampled at the robot's own time
  kGenerator,      ///< the reference generator; the velocity is formed from the positions
  kRateMatching,   ///< a source of 125 Hz and the moving average over 8 cycles
  kGivenVelocity,  ///< the reference generator with a velocity from the source
};
/// @returns an undisturbed 1 kHz stream behind the remedy.
[[nodiscard]] Stream StreamBehind(Remedy remedy, const scenario::RobotData& robot);

/// The brisk trajectory, stretched in time until its largest acceleration is `share` of the limit.
/// @throws InputError when that breaks another limit.
[[nodiscard]] reference::Trajectory BriskAt(const Config& config, const JointLimits& limits,
                                            double share);

/// From rest to rest in 1 s, out of the ready pose: q(s) = q0 + d (10 s^3 - 15 s^4 + 6 s^5); the
/// speed has its peak 1.875 d / s in the middle, the acceleration 5.774 d / s^2 at 0.21 and 0.79 s.
[[nodiscard]] reference::Trajectory SecondOfMotion(const JointVector& displacement,
                                                   const JointLimits& limits);

/// The phase with which a source that is `ppm` fast crosses the robot's cycles at a random time
/// within the plan. @param ppm  > 0. @param choice  uniform in [0, 1).
[[nodiscard]] Duration PhaseOfOvertaking(const reference::Trajectory& plan, double ppm,
                                         double choice);

/// @returns the stages of `tick` with libfranka's rate limiter behind them.
[[nodiscard]] loop::TickConfig WithLimiter(loop::TickConfig tick, const scenario::RobotData& robot);

/// Largest component.
[[nodiscard]] double Largest(const JointVector& values) noexcept;

}  // namespace twin::experiment
