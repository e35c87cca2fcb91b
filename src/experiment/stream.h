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
#include "twin/reference/joint_target.h"
#include "twin/reference/trajectory.h"
#include "twin/scenario/robot_data.h"

namespace twin::experiment {

/// Where a deposited position gets its velocity.
enum class VelocityFrom : std::uint8_t {
  kGiven,        ///< the source knows it
  kSourceTime,   ///< difference of two deposits over the source's own elapsed time
  kNominalTime,  ///< the same over the nominal period
  kConsumption,  ///< difference of what two commands in a row consumed over the robot's cycle
};

/// A source that samples a planned trajectory with a clock of its own, and what stands between its
/// deposits and the robot. Deposit i is sampled at i P + dt(i) of the source's clock, deposited at
/// once, and consumed by the robot's cycles at k T: the newest that is there. The link takes no
/// time and loses nothing.
struct Stream {
  /// What experiments vary of the command chain; source_rate_hz is the source's.
  loop::TickConfig tick{.generator = loop::Generator::kNone, .limiter = {}, .cost = {}};
  control::CommandInterface interface = control::CommandInterface::kJointPosition;
  VelocityFrom velocity = VelocityFrom::kSourceTime;
  /// Sampled at the robot's own time (message_id), one for each cycle, instead of by a clock.
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
  const onboard::JointReference& next;   ///< what INT makes of the command
  const reference::JointTarget& target;  ///< that was consumed
};

/// What became of a stream.
struct StreamResult {
  std::uint64_t cycles = 0;                ///< with a command
  std::optional<std::uint64_t> aborted{};  ///< first cycle that INT refuses
  JointVector jerk{};                      ///< largest, as a share of its limit
  JointVector rms_jerk{};                  ///< root of the mean square, the same
  /// Largest share of a limit of velocity, acceleration or jerk: above 1 the joint alone aborts.
  JointVector share{};
};

/// What INT does on an ideal plant with such a stream: the command chain as the tick runs it
/// (loop::CommandChain), INT's backward differences (onboard::JointReference) and its checks
/// (onboard::CheckStep); from rest at the trajectory's start to 20 cycles after its end.
///
/// Threads: any. @param stops  at the first refused command, as the robot does; else it is taken
/// all the same, so that all of the stream can be looked at. @param tell  of each cycle; may be
/// empty. @throws InputError as TickConfig::Validate.
[[nodiscard]] StreamResult RunStream(const reference::Trajectory& plan, const JointLimits& limits,
                                     const Stream& stream, bool stops,
                                     const std::function<void(const StreamCycle&)>& tell = {});

/// The Panda, and the motions of the experiments that look at streams.
struct StreamSetting {
  scenario::RobotData robot;
  reference::Trajectory canonical;  ///< of the calibrated asynchronous loop
};
/// @throws InputError as Load.
[[nodiscard]] StreamSetting LoadStreamSetting(const Setting& setting);

/// The brisk trajectory, run so fast that its largest acceleration is `share` of the limit.
/// @throws InputError when that breaks another limit.
[[nodiscard]] reference::Trajectory BriskAt(const Setting& setting, const JointLimits& limits,
                                            double share);

/// From rest to rest in 1 s, out of the ready pose: q(s) = q0 + d (10 s^3 - 15 s^4 + 6 s^5); the
/// speed has its peak 1.875 d / s in the middle, the acceleration 5.774 d / s^2 at 0.21 and 0.79 s.
[[nodiscard]] reference::Trajectory SecondOfMotion(const JointVector& displacement,
                                                   const JointLimits& limits);

/// A chain that continues with libfranka's rate limiter. @returns the stages of `tick` with it.
[[nodiscard]] loop::TickConfig WithLimiter(loop::TickConfig tick, const scenario::RobotData& robot);

/// Largest component.
[[nodiscard]] double Largest(const JointVector& values) noexcept;

}  // namespace twin::experiment
