#pragma once

#include <optional>
#include <span>
#include <string_view>

#include "twin/core/realtime.h"

namespace twin::reference {

/// Bounds of one joint's reference; magnitudes except for the range.
struct AxisBounds {
  double q_min = 0;            ///< rad
  double q_max = 0;            ///< rad
  double dq_max = 0;           ///< rad/s
  double ddq_max = 0;          ///< rad/s^2
  double dddq_max = 0;         ///< rad/s^3
  double velocity_offset = 0;  ///< rad/s, as JointLimits::velocity_offset
  double deceleration = 0;     ///< rad/s^2; zero: dq_max everywhere
};

/// A joint's reference in the robot.
struct AxisState {
  double q = 0;    ///< rad
  double dq = 0;   ///< rad/s
  double ddq = 0;  ///< rad/s^2
};

/// A possible state of a joint when a command arrives.
struct PossibleState {
  AxisState x;
  double extra = 0;  ///< rad/s^3: extra jerk of one command here, relative to the first state
};

/// Admissible jerks of a command, rad/s^3.
struct JerkRange {
  double lowest = 0;
  double highest = 0;
  [[nodiscard]] bool empty() const noexcept { return !(lowest <= highest); }
};

/// The states of one joint from which its bounds can be kept at all times, whichever commands are
/// lost, as long as at most n consecutive ones are: the largest such set, in closed form.
///
/// An arriving command changes the acceleration by T j and integrates (backward differences, T = 1
/// ms); a lost one keeps the acceleration, like a command with j = 0:
///   f(x, j):  a+ = a + T j,  v+ = v + T a+,  q+ = q + T v+,     H x = f(x, 0).
/// With B the hardest braking downwards, a+ = max(a - T J, -A), the worst sequence for the upper
/// bounds is H^n B H^n B ... until v <= 0 and a <= 0. Its rise above its start, P(v, a), does not
/// depend on q. A state is viable when
///   |a| <= A,   q + P(v, a) <= q_max,   speed along that sequence <= V,   and the same mirrored.
/// Where the velocity limit shrinks towards the ends of the range, P has room for it: see below.
/// Definitions, lemmas and proofs: src/reference/VIABILITY.md.
///
/// From a viable state some jerk leads to a viable one, for any pattern of up to n consecutive
/// losses, if upper and lower bounds never bind at once. For this it suffices that
///   q_max - q_min >= P(0, A),   V >= velocity gained on the worst sequence from v = 0, a = A.
/// Other bounds are rejected. No smaller range is enough.
///
/// With a deceleration d and an offset o (FR3) the limit of a step from q is U(q) =
/// min(V, max(0, sqrt(2 d (q_max - q)) - o)). A step to a speed v > 0 then needs q_max to be
/// (v + o)^2 / (2 d) above its begin, and P is the highest such need of all steps. The condition on
/// the range becomes q_max - q_min >= P(G, 0) + P(0, A), with G the velocity gained, and each
/// of the two at least o^2 / (2 d).
///
/// The enforced bounds are a millionth inside the given ones, so that rounding, here or in the
/// robot, never leads outside.
///
/// Threads: constant after construction. Real-time: noexcept, allocates nothing; O(rounds), with at
/// most 12 rounds for a joint of the Panda and n = 19, 150 for n = 0.
class ViableAxis {
 public:
  static constexpr int kMostLost = 100;

  /// @param lost  n, in [0, kMostLost]. @param name  of the joint, for messages.
  /// @throws InputError for bounds that are not finite or positive, an n out of range, or a
  /// violation of the condition above; the text says which, and what would be enough.
  ViableAxis(const AxisBounds& bounds, int lost, std::string_view name);

  /// Whether the state is viable.
  [[nodiscard]] bool Contains(const AxisState& x) const noexcept TWIN_REALTIME;

  /// The admissible jerk nearest to the requested one. From a state outside the set, by rounding or
  /// other causes: the jerk that brakes hardest towards it.
  /// @param x  the answered state. @param wish  rad/s^3; not finite: hardest braking of the speed.
  [[nodiscard]] double Nearest(const AxisState& x, double wish) const noexcept TWIN_REALTIME;

  /// The same for a command that must be admissible in several states. A single state gives
  /// Nearest(); several may have no common jerk, hence nullopt.
  /// @param states  at least one. @param wish  jerk in the first state, like the result.
  [[nodiscard]] std::optional<double> NearestOfAll(std::span<const PossibleState> states,
                                                   double wish) const noexcept TWIN_REALTIME;

  /// All admissible jerks. Costs about sixty times Contains(). Empty outside the set.
  [[nodiscard]] JerkRange Admissible(const AxisState& x) const noexcept TWIN_REALTIME;

  /// Distance to the border of the set: the smallest remainder of a bound on the worst sequences,
  /// as a share of the bound (range or speed). Negative outside; zero on the border.
  [[nodiscard]] double Margin(const AxisState& x) const noexcept TWIN_REALTIME;

  /// f(x, jerk).
  [[nodiscard]] static AxisState Step(const AxisState& x, double jerk) noexcept TWIN_REALTIME;
  /// Its inverse: the jerk from x of a commanded position (rad) or velocity (rad/s).
  [[nodiscard]] static double JerkToPosition(const AxisState& x, double q_c) noexcept TWIN_REALTIME;
  [[nodiscard]] static double JerkToVelocity(const AxisState& x,
                                             double dq_c) noexcept TWIN_REALTIME;

  [[nodiscard]] int lost() const noexcept { return lost_; }
  /// The enforced bounds: a millionth inside the given ones.
  [[nodiscard]] const AxisBounds& kept() const noexcept { return kept_; }
  /// Longest travel from full speed and acceleration, P(V, A), rad.
  [[nodiscard]] double longest_way() const noexcept { return longest_way_; }
  /// The smallest accepted range, rad, between the enforced bounds.
  [[nodiscard]] double least_range() const noexcept { return least_range_; }

 private:
  /// Reach of the worst sequence above its start.
  struct Reach {
    double q = 0;   ///< P, rad, >= 0: no less than the highest position
    double dq = 0;  ///< highest velocity, rad/s
  };
  enum class Side { kUpper, kLower };

  [[nodiscard]] Reach ReachOf(double dq, double ddq) const noexcept;
  /// What a step to this velocity needs of the range above its begin, rad.
  [[nodiscard]] double NeedOfStep(double dq) const noexcept;
  /// The largest need of the held steps from here, above the position here, rad.
  [[nodiscard]] double NeedOfHeld(double dq, double ddq) const noexcept;
  [[nodiscard]] bool KeepsUpper(const AxisState& x) const noexcept;
  [[nodiscard]] bool Keeps(Side side, const AxisState& x) const noexcept;
  [[nodiscard]] double Braking(Side side, double ddq) const noexcept;
  [[nodiscard]] JerkRange Feasible(double ddq) const noexcept;
  [[nodiscard]] bool KeepsAll(Side side, std::span<const PossibleState> states,
                              double jerk) const noexcept;
  [[nodiscard]] double Bisect(Side side, std::span<const PossibleState> states, double keeps,
                              double breaks) const noexcept;
  /// @param gathered  velocity of the worst sequence from v = 0, a = A, rad/s.
  void RequireNoConflict(double gathered, std::string_view name) const;

  int lost_;
  AxisBounds kept_;
  int rounds_ = 0;  ///< of the worst sequence, at most
  double longest_way_ = 0;
  double least_range_ = 0;
};

/// Requirements of the viability filters on limits and n. Both functions throw InputError.
///
/// A magnitude must be finite and positive. @param name  of the joint or motion. @param field  of
/// its bounds.
void RequireMagnitude(std::string_view name, std::string_view field, double value);
/// n must be in [0, ViableAxis::kMostLost].
void RequireLost(int lost);

}  // namespace twin::reference
