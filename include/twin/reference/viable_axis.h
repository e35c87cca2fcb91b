#pragma once

#include <optional>
#include <span>
#include <string_view>

#include "twin/core/realtime.h"

namespace twin::reference {

/// What one joint's reference must keep for ever. Magnitudes, but for the range.
struct AxisBounds {
  double q_min = 0;     ///< rad
  double q_max = 0;     ///< rad
  double dq_max = 0;    ///< rad/s
  double ddq_max = 0;   ///< rad/s^2
  double dddq_max = 0;  ///< rad/s^3
};

/// A joint's reference as the robot holds it.
struct AxisState {
  double q = 0;    ///< rad
  double dq = 0;   ///< rad/s
  double ddq = 0;  ///< rad/s^2
};

/// One of the states that a joint may be in when a command arrives.
struct PossibleState {
  AxisState x;
  double extra = 0;  ///< rad/s^3: how much more jerk one command has here than in the first of them
};

/// Jerks that a command may have, rad/s^3.
struct JerkRange {
  double lowest = 0;
  double highest = 0;
  [[nodiscard]] bool empty() const noexcept { return !(lowest <= highest); }
};

/// The states of one joint from which its bounds can be kept for ever, whatever commands are lost,
/// as long as no more than n are lost in a row: the largest such set, in closed form.
///
/// A command that arrives changes the acceleration by T j and integrates (backward differences, T =
/// 1 ms); one that is lost leaves the acceleration, which is a command with j = 0:
///   f(x, j):  a+ = a + T j,  v+ = v + T a+,  q+ = q + T v+,     H x = f(x, 0).
/// With B the hardest braking downwards, a+ = max(a - T J, -A), the worst that can happen to the
/// upper bounds is H^n B H^n B ... until v <= 0 and a <= 0; what that reaches above its start, P(v,
/// a), does not depend on q. A state is viable when
///   |a| <= A,   q + P(v, a) <= q_max,   its speed on that way <= V,   and the same mirrored.
/// Definitions, lemmas and proofs: src/reference/VIABILITY.md.
///
/// From a viable state a jerk exists that leads to a viable one, whatever of up to n losses comes
/// between, if upper and lower bounds never bind at once, for which it is enough that
///   q_max - q_min >= P(0, A),   V >= what the worst way gathers from v = 0, a = A.
/// Other bounds are refused. No smaller range is enough.
///
/// The bounds kept are a millionth inside the given ones, so that rounding, of ours or the robot's,
/// never leads outside.
///
/// Threads: constant after construction. Real-time: noexcept, allocates nothing; O(rounds), which
/// is bounded by the bounds: 12 for a joint of the Panda and n = 19, 150 for n = 0.
class ViableAxis {
 public:
  static constexpr int kMostLost = 100;

  /// @param lost  n, in [0, kMostLost]. @param name  of the joint, for messages.
  /// @throws InputError for bounds that are not finite or positive, an n out of range, and where
  /// the condition above is not met: says which, and what would be enough.
  ViableAxis(const AxisBounds& bounds, int lost, std::string_view name);

  /// Whether the state is viable.
  [[nodiscard]] bool Contains(const AxisState& x) const noexcept TWIN_REALTIME;

  /// The jerk nearest to the wished one that a command may have. From a state outside the set, by
  /// rounding or because it was left otherwise, the jerk that brakes hardest towards it.
  /// @param x  that the command answers. @param wish  rad/s^3; not finite: that of hardest braking
  /// of the speed.
  [[nodiscard]] double Nearest(const AxisState& x, double wish) const noexcept TWIN_REALTIME;

  /// The same for a command that has to do in each of several states. From a single one it is
  /// Nearest(); of more, there may be none that does.
  /// @param states  at least one. @param wish  jerk in the first of them, as is what is returned.
  [[nodiscard]] std::optional<double> NearestOfAll(std::span<const PossibleState> states,
                                                   double wish) const noexcept TWIN_REALTIME;

  /// All such jerks. Costs some sixty times Contains(). Empty outside the set.
  [[nodiscard]] JerkRange Admissible(const AxisState& x) const noexcept TWIN_REALTIME;

  /// How far inside the set: the least of what is left of each bound on the worst ways, as a share
  /// of the bound (of the range, of the speed). Negative outside; zero on its border.
  [[nodiscard]] double Margin(const AxisState& x) const noexcept TWIN_REALTIME;

  /// f(x, jerk).
  [[nodiscard]] static AxisState Step(const AxisState& x, double jerk) noexcept TWIN_REALTIME;
  /// Its inverse: the jerk that a command is from x, a position (rad) or a velocity (rad/s).
  [[nodiscard]] static double JerkToPosition(const AxisState& x, double q_c) noexcept TWIN_REALTIME;
  [[nodiscard]] static double JerkToVelocity(const AxisState& x,
                                             double dq_c) noexcept TWIN_REALTIME;

  [[nodiscard]] int lost() const noexcept { return lost_; }
  /// The bounds that are kept: a millionth inside those given.
  [[nodiscard]] const AxisBounds& kept() const noexcept { return kept_; }
  /// How far a joint may go on from full speed and acceleration, P(V, A), rad.
  [[nodiscard]] double longest_way() const noexcept { return longest_way_; }
  /// The smallest range that is not refused, P(0, A), rad, between the bounds that are kept.
  [[nodiscard]] double least_range() const noexcept { return least_range_; }

 private:
  /// What the worst way reaches above its start.
  struct Reach {
    double q = 0;   ///< P, rad, >= 0
    double dq = 0;  ///< highest velocity, rad/s
  };
  enum class Side { kUpper, kLower };

  [[nodiscard]] Reach ReachOf(double dq, double ddq) const noexcept;
  [[nodiscard]] bool KeepsUpper(const AxisState& x) const noexcept;
  [[nodiscard]] bool Keeps(Side side, const AxisState& x) const noexcept;
  [[nodiscard]] double Braking(Side side, double ddq) const noexcept;
  [[nodiscard]] JerkRange Feasible(double ddq) const noexcept;
  [[nodiscard]] bool KeepsAll(Side side, std::span<const PossibleState> states,
                              double jerk) const noexcept;
  [[nodiscard]] double Bisect(Side side, std::span<const PossibleState> states, double keeps,
                              double breaks) const noexcept;
  void RequireNoConflict(std::string_view name) const;

  int lost_;
  AxisBounds kept_;
  int rounds_ = 0;  ///< of the worst way, at most
  double longest_way_ = 0;
  double least_range_ = 0;
};

}  // namespace twin::reference
