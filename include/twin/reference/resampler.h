#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "twin/core/joint_vector.h"
#include "twin/core/realtime.h"
#include "twin/core/time.h"

namespace twin::reference {

/// Plays a source's deposits back, evenly: at times that advance with the robot's cycles, whenever
/// the deposits came. A deposit consumed twice, one skipped, and the jitter of the instant at which
/// each was sampled then no longer are steps of the reference: the value between two deposits is
/// that of a cubic through them, at the source's own times.
///
///   t(k+1) = t(k) + T (1 + r),   lag(k) = t_newest - t(k) at a deposit's arrival
///   r = kp e + ki sum e,  e = lag - 2.25 periods, low-passed
///
/// The play time is phase-locked to the source: r follows its clock's drift, at most 0.5 %. The lag
/// of 2.25 periods is what a cubic whose slopes are central differences asks for (two), and a
/// quarter for jitter. Slopes are formed from positions and times alone, since a deposited velocity
/// is the mean since the deposit before.
///
/// When deposits fail to come, the motion is taken to go on for three periods, and then stands at
/// the last one. A source whose time jumps (it
/// stalled, and went on) is jumped after; what that makes of the reference, the generator behind
/// takes away.
///
/// Source: the paper's section on sampling jitter names deposits consumed twice or skipped as the
/// cause of jerk; this cure is our decision.
///
/// Threads: one. Real-time: noexcept, allocates nothing, O(1).
class Resampler {
 public:
  /// @param source_rate_hz  in [1, 1000]. @throws InputError naming the value and the range.
  explicit Resampler(double source_rate_hz);

  /// A motion begins: what is played is `q` (rad) until the first deposits.
  void Reset(const JointVector& q) noexcept TWIN_REALTIME;

  /// A deposit has come. One whose time does not rise takes the last one's place.
  /// @param source_time  when the source sampled it, by its own clock. @param q  rad.
  void Deposit(Time source_time, const JointVector& q) noexcept TWIN_REALTIME;

  /// One cycle of the robot on. @returns the reference then, rad.
  [[nodiscard]] JointVector Next() noexcept TWIN_REALTIME;

  /// Whether what is played stands at the last deposit, or where the motion begins.
  [[nodiscard]] bool ended() const noexcept { return ended_; }

  /// How far the play time is behind the source's, by design, s.
  [[nodiscard]] double lag_s() const noexcept { return lag_s_; }

 private:
  struct Knot {
    double t = 0;  ///< s since the first deposit
    JointVector q{};
  };
  static constexpr std::size_t kKnots = 8;

  void Append(const Knot& knot) noexcept;
  void Lock(double newest) noexcept;
  [[nodiscard]] JointVector Play() const noexcept;
  [[nodiscard]] JointVector Beyond() const noexcept;
  [[nodiscard]] double Slope(std::size_t knot, std::size_t joint) const noexcept;

  double lag_s_;
  double period_s_;
  std::array<Knot, kKnots> knots_{};  ///< in order of time
  std::size_t count_ = 0;
  Time first_{};
  double t_ = 0;      ///< play time, s since the first deposit
  double error_ = 0;  ///< low-passed, s
  double drift_ = 0;  ///< of the source's clock, as seen so far
  double rate_ = 0;   ///< r
  bool ended_ = true;
};

}  // namespace twin::reference
