#pragma once

#include "experiment/runs.h"
#include "twin/control/controller.h"
#include "twin/core/limits.h"
#include "twin/core/robot_state.h"
#include "twin/loop/command_chain.h"
#include "twin/onboard/joint_reference.h"
#include "twin/reference/target.h"

namespace twin::experiment {

/// Source of a deposited position's velocity.
enum class VelocityFrom : std::uint8_t {
  kGiven,        ///< given by the source
  kSourceTime,   ///< difference of two deposits over the source's own elapsed time
  kNominalTime,  ///< the same over the nominal period
  kConsumption,  ///< difference of two consumed positions over the robot's cycle
};

[[nodiscard]] JointVector MiddleOf(const JointLimits& limits) noexcept;

/// The workstation's command chain and the robot controller's reference behind it, cycle by cycle,
/// without a link between them: the robot takes every command in time.
///
/// Threads: one.
class ChainBench {
 public:
  /// @param q_d  initial reference, 7, rad, at rest. @throws InputError as TickConfig::Validate.
  ChainBench(const loop::TickConfig& config, const JointVector& q_d,
             control::CommandInterface interface = control::CommandInterface::kJointPosition);

  /// One cycle. @param target  newest deposit. @param fresh  it was deposited since the last cycle,
  /// at source_time. @param is_lost  the command is lost: the robot holds its acceleration.
  /// @returns INT's reference after it.
  const onboard::JointReference& Step(const reference::JointTarget& target, bool fresh,
                                      Time source_time, bool is_lost = false) noexcept;

  /// The same, with a deposit of joint 1 alone, rad and rad/s; the other joints stay.
  void Step(double q_ext, double dq_ext, bool fresh, bool is_lost = false) noexcept;

  /// Of joint 1, after the last cycle.
  [[nodiscard]] double q_d() const noexcept { return reference_.q_d[0]; }
  [[nodiscard]] double dq_d() const noexcept { return reference_.dq_d[0]; }
  [[nodiscard]] double ddq_d() const noexcept { return reference_.ddq_d[0]; }
  [[nodiscard]] double jerk() const noexcept { return reference_.dddq_d[0]; }
  /// Largest share of its limits (TickConfig::limits) of velocity, acceleration and jerk.
  [[nodiscard]] double LargestShare() const noexcept;
  /// record::TickRecord::margin of the last state, and whether the filter changed joint 1.
  [[nodiscard]] std::optional<double> margin() const noexcept { return chain_.margin(); }
  [[nodiscard]] bool kept_back() const noexcept { return (chain_.changed_joints() & 1U) != 0; }

 private:
  void Show() noexcept;

  const control::CommandInterface interface_;
  const JointLimits limits_;
  loop::CommandChain chain_;
  reference::JointTarget target_;  ///< of joint 1's steps
  onboard::JointReference reference_;
  RobotState state_;
  Time now_{};
  Time source_time_{};  ///< of the newest deposit of joint 1
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

/// Result of a stream.
struct StreamResult {
  std::uint64_t cycles = 0;                ///< with a command
  std::optional<std::uint64_t> aborted{};  ///< first cycle that INT refuses
  JointVector jerk{};                      ///< largest, as a share of its limit
  JointVector rms_jerk{};                  ///< root of the mean square, the same
  /// Largest share of a limit of velocity, acceleration or jerk: above 1 the joint alone aborts.
  JointVector share{};
};

using TellCycle = std::function<void(std::uint64_t k, const onboard::JointReference& next)>;

/// Feeds a stream to INT on an ideal plant: the command chain as the tick runs it
/// (loop::CommandChain), INT's backward differences (onboard::JointReference) and its checks
/// (onboard::CheckStep); from rest at the trajectory's start to 20 cycles after its end.
///
/// Threads: any. @param stops  ends at the first refused command, as the robot does; else the robot
/// takes it all the same, so that the result covers the whole stream. @param tell  receives each
/// cycle k (the first with a deposit is not always 0) and INT's reference after its command; may be
/// empty. @throws InputError as TickConfig::Validate.
[[nodiscard]] StreamResult RunStream(const reference::Trajectory& plan, const JointLimits& limits,
                                     const Stream& stream, bool stops, const TellCycle& tell = {});

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
/// speed has its peak kPeakOfSecond d / s in the middle, the acceleration 5.774 d / s^2 at 0.21 and
/// 0.79 s.
inline constexpr double kPeakOfSecond = 1.875;
[[nodiscard]] reference::Trajectory SecondOfMotion(const JointVector& displacement,
                                                   const JointLimits& limits);

/// The phase with which a source that is `ppm` fast crosses the robot's cycles at a random time
/// within the plan. @param ppm  > 0. @param choice  uniform in [0, 1).
[[nodiscard]] Duration PhaseOfOvertaking(const reference::Trajectory& plan, double ppm,
                                         double choice);

/// @returns the stages of `tick` with libfranka's rate limiter behind them.
[[nodiscard]] loop::TickConfig WithLimiter(loop::TickConfig tick, const scenario::RobotData& robot);

[[nodiscard]] double Largest(const JointVector& values) noexcept;

/// The paper's jitter, s.
inline constexpr double kPaperJitter = 4e-6;

/// Drift of a source's own clock, ppm.
inline constexpr double kFreeRunningPpm = 50;

/// A stream behind a remedy, with seed and phase of a run. @param jitter_s, ppm  as
/// Stream::jitter_s and clock_ppm.
[[nodiscard]] Stream StreamOfRun(const Config& config, Remedy remedy,
                                 const scenario::RobotData& robot, double jitter_s, double ppm,
                                 int run);

/// Several runs of a stream.
struct StreamRuns {
  double aborted = 0;   ///< share of runs
  double jerk = 0;      ///< largest of all, as a share of its limit
  double rms_jerk = 0;  ///< mean over the runs of the worst joint's, as a share of its limit
};
[[nodiscard]] StreamRuns SummaryOf(std::span<const StreamResult> results);

/// Of the first remedies, which experiment jitter compares.
inline constexpr std::array<std::string_view, 5> kRemedyNames{
    "raw", "rate limiter", "low-pass 100 Hz", "INT timestamps", "reference generator"};

/// Jerk caused by jitter, as INT reconstructs it and by formula. T the period of 1 ms,
///   position: dq*((k - 1.5) T) D3 dt(k) / T^3,   velocity: ddq*((k - 1) T) D2 dt(k) / T^2,
/// D2 and D3 the second and third backward difference, both derivatives in the middle of the
/// samples that make the difference.
struct JitterJerk {
  std::vector<double> t{};                              ///< s
  std::array<std::vector<double>, kJoints> measured{};  ///< of the jittered less the exact stream
  std::array<std::vector<double>, kJoints> formula{};
  double residual = 0;  ///< RMS of their difference over all joints and samples / that of formula
  double ratio = 0;     ///< RMS of measured / RMS of formula
};
[[nodiscard]] JitterJerk JerkOfJitter(const reference::Trajectory& plan, const JointLimits& limits,
                                      control::CommandInterface interface, double jitter_s,
                                      std::uint64_t seed);

/// Probability of an abort within 1 s of motion, by Remedy.
using AbortShares = std::array<double, kRemedyNames.size()>;
/// A row for each speed, in it an entry for each jitter.
using AbortMap = Grid<AbortShares>;
/// @param speed  peak of joint 1, rad/s. @param runs  of each place, >= 1.
[[nodiscard]] AbortMap MapAborts(const Config& config, const scenario::RobotData& robot,
                                 std::span<const double> jitter_us, std::span<const double> speed,
                                 int runs);

/// The reference generator's output at one pace of the brisk trajectory.
struct PaceResult {
  double acceleration = 0;  ///< largest, as a share of its limit
  double jerk = 0;          ///< largest of all runs, as a share of its limit
  double aborted = 0;       ///< share of runs
};
[[nodiscard]] std::vector<PaceResult> MeasurePaces(const Config& config, const StreamInputs& inputs,
                                                   const std::vector<double>& shares, int runs);

/// The acceleration at which the line through the results first meets jerk 1; NaN if it does not.
[[nodiscard]] double ShareAtLimit(const std::vector<PaceResult>& paces) noexcept;

/// Effect of noise of several amplitudes in 1 s of motion.
struct NoiseCurves {
  std::vector<double> amplitude;  ///< rad, rising
  /// Share of runs that the joint alone would have aborted, [joint][amplitude].
  std::array<std::vector<double>, kJoints> aborted;
  std::array<std::vector<double>, kJoints> rms_jerk;  ///< mean over the runs, of its limit
};
/// All joints move gently, at 2 % of their acceleration limits; each has its noise, and each is
/// judged on its own. @param runs  of each amplitude, >= 1.
[[nodiscard]] NoiseCurves MeasureNoise(const Config& config, const scenario::RobotData& robot,
                                       Remedy remedy, const std::vector<double>& amplitude,
                                       int runs);

/// The amplitude at which half of the runs abort, between two amplitudes on a logarithmic scale;
/// infinite without such an amplitude. @param joint  from 0.
[[nodiscard]] double HalfAborted(const NoiseCurves& curves, std::size_t joint);

/// Runs of the reference generator with dq_ext formed in one manner.
/// @param jitter_s  of the sampling. @param ppm  >= 0, between the two clocks; 0: the phase of the
/// two loops stays half a cycle. Otherwise every run meets a crossing. @param runs  >= 1.
[[nodiscard]] StreamRuns RunFeedForward(const Config& config, const reference::Trajectory& plan,
                                        const JointLimits& limits, VelocityFrom velocity,
                                        double jitter_s, double ppm, int runs);

}  // namespace twin::experiment
