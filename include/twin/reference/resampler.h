#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "twin/core/joint_vector.h"
#include "twin/core/limits.h"
#include "twin/core/realtime.h"
#include "twin/core/time.h"

namespace twin::reference {

/// Which sources are rough (Resampler): above J on any axis.
struct Roughness {
  static constexpr double kNone = std::numeric_limits<double>::infinity();

  JointVector limit{kNone, kNone, kNone, kNone, kNone, kNone, kNone};  ///< J, unit/s^3
  int order = 3;  ///< derivative of the values that J bounds: 3 of positions, 2 of velocities
};

/// Reads a source's deposits at times that advance with the robot's cycles. So deposits consumed
/// twice, skipped or late, and jitter of the sampling times, cause no steps in the reference. With
/// t the play time on the source's clock,
///   x(t) = the cubic through the deposits, slopes by central differences; beyond the newest
///          deposit the parabola that continues it, of constant acceleration;
///   t(k+1) = t(k) + T (1 + r),   lag(k) = t_newest - t(k) at a deposit's arrival,
///   r = kp e + ki sum e,   e = lag - 2.25 periods, low-passed.
///
/// The play time is phase-locked to the source: r follows its clock's drift, at most 0.5 %. The lag
/// of 2.25 periods is two for a cubic with central differences and a quarter for jitter. Slopes use
/// positions and times only, since a deposited velocity is the mean since the deposit before. When
/// the source is more than 2 periods ahead (the robot stopped, or cycles were missed), the play
/// time jumps to the lag.
///
/// A stopped source stays at its last deposit; the curve restarts at the next one. It also restarts
/// when the source's clock is set back.
///
/// A late deposit also changes the curve's past: Value(1) is the curve one cycle ago as known now.
/// So a correction that compares the robot's reference with Value(1), (2) and (3) sees new
/// knowledge as an offset, not as a velocity.
///
/// A rough source is one that no robot can follow: noise of 2 urad at 1 kHz already demands the
/// jerk limit in each cycle. With d(k) the jerk of the curve, clipped at 4 limits, averaged over 64
/// cycles, the source is rough from mean |d| > J on any axis until mean |d| < J / 2 on all. A rough
/// source is played by a tracker, critically damped, in place of the curve:
///   x(k+1) = x + T v + 2 w T (r - x - T v),   v(k+1) = v + w^2 T (r - x - T v),   w = 50 1/s,
/// with r the curve: the noise is averaged over 20 ms, and constant velocities are followed without
/// lag. Source() stays that of the curve.
///
/// Source: the paper's section on sampling jitter names deposits consumed twice or skipped as the
/// cause of jerk; this remedy is a decision.
///
/// Threads: one. Real-time: noexcept, allocates nothing, O(1).
class Resampler {
 public:
  /// Number of values: of the next cycle and of the three before it.
  static constexpr std::size_t kPlayed = 4;

  /// @param source_rate_hz  in [1, 1000]. @throws InputError naming the value and the range.
  explicit Resampler(double source_rate_hz, const Roughness& roughness = {});

  /// Starts a motion: plays `x` until the first deposit. Seven values of one unit each: joint
  /// positions (rad), velocities (rad/s), or coordinates of a pose.
  void Reset(const JointVector& x) noexcept TWIN_REALTIME;

  /// Adds a deposit; one whose time does not increase replaces the last.
  /// @param source_time  sampling time on the source's clock.
  void Deposit(Time source_time, const JointVector& x) noexcept TWIN_REALTIME;

  /// Advances by one cycle of the robot.
  void Advance() noexcept TWIN_REALTIME;

  /// Declares the source stalled.
  void Stop() noexcept TWIN_REALTIME { stopped_ = true; }

  /// The value played `cycles` before the present cycle, in [0, kPlayed); of a rough source the
  /// line through the tracker's present value.
  [[nodiscard]] JointVector Value(std::size_t cycles = 0) const noexcept TWIN_REALTIME;

  [[nodiscard]] bool is_rough() const noexcept { return rough_; }

  /// The source's own value at that cycle, ahead of Value() by the lag.
  [[nodiscard]] JointVector Source(std::size_t cycles = 0) const noexcept TWIN_REALTIME {
    return At(t_[cycles] + lag_s_);
  }

  /// Advance of the play time per cycle, s: T (1 + r).
  [[nodiscard]] double step_s() const noexcept { return kCycleSeconds * (1 + rate_); }

  /// Designed lag of the play time behind the source, s.
  [[nodiscard]] double lag_s() const noexcept { return lag_s_; }

 private:
  struct Knot {
    double t = 0;  ///< s since the first deposit
    JointVector x{};
  };
  static constexpr std::size_t kKnots = 12;

  void Begin(Time source_time, const JointVector& x) noexcept;
  /// Judges the curve of the present cycle, and tracks it if the source is rough.
  void Track() noexcept;
  void Append(const Knot& knot) noexcept;
  void Lock(double newest) noexcept;
  [[nodiscard]] JointVector At(double t) const noexcept;
  /// x(t_last + s) = x_last + s (slope + s bend).
  struct Parabola {
    double slope = 0;
    double bend = 0;
  };
  [[nodiscard]] Parabola Beyond(std::size_t axis) const noexcept;
  [[nodiscard]] double Chord(std::size_t from, std::size_t to, std::size_t axis) const noexcept;
  [[nodiscard]] double Slope(std::size_t knot, std::size_t axis) const noexcept;

  double period_s_;
  double lag_s_;
  std::array<Knot, kKnots> knots_{};  ///< ordered by time
  std::size_t count_ = 0;
  Time first_{};
  std::array<double, kPlayed> t_{};  ///< play times, newest first, s since the first deposit
  bool stopped_ = true;
  Roughness roughness_;
  JointVector mean_{};  ///< of |d|, in limits
  bool rough_ = false;
  JointVector x_{}, v_{};  ///< of the tracker
  double error_ = 0;       ///< low-passed, s
  double drift_ = 0;       ///< estimate for the source's clock
  double rate_ = 0;        ///< r
};

/// A Resampler for poses: position by its coordinates, m; rotation by the components of a unit
/// quaternion, normalised after interpolation. For deposits a few degrees apart this equals the
/// cubic on rotations up to third order in the angle.
///
/// Play time, lag, stop, threads and real-time: as Resampler.
class PoseResampler {
 public:
  /// @param source_rate_hz  as in Resampler. @throws as Resampler.
  /// @param limits  0.15 of their jerks are J.
  PoseResampler(double source_rate_hz, const CartesianLimits& limits);

  void Reset(const Transform& O_T_EE) noexcept TWIN_REALTIME;
  void Deposit(Time source_time, const Transform& O_T_EE) noexcept TWIN_REALTIME;
  void Advance() noexcept TWIN_REALTIME { resampler_.Advance(); }
  void Stop() noexcept TWIN_REALTIME { resampler_.Stop(); }
  [[nodiscard]] Transform Value(std::size_t cycles = 0) const noexcept TWIN_REALTIME;
  [[nodiscard]] Transform Source() const noexcept TWIN_REALTIME;

 private:
  /// [p; w, x, y, z], with the sign of the quaternion that is nearest to the last one.
  [[nodiscard]] JointVector CoordinatesOf(const Transform& O_T_EE) const noexcept;

  Resampler resampler_;
  JointVector last_{0, 0, 0, 1, 0, 0, 0};
};

}  // namespace twin::reference
