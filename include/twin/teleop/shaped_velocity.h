#pragma once

#include <algorithm>

#include <Eigen/Core>

#include "twin/core/realtime.h"

namespace twin::teleop {

/// Bounds of a commanded motion, on the norms of its vectors.
struct MotionBounds {
  double speed = 0;         ///< m/s or rad/s, > 0
  double acceleration = 0;  ///< m/s^2 or rad/s^2, > 0
  double jerk = 0;          ///< m/s^3 or rad/s^3, > 0
  bool operator==(const MotionBounds&) const = default;
};

/// A velocity that follows a command u within bounds of speed, acceleration and jerk: the two inner
/// loops of the saturated correction in reference/rejoining_generator.h, for vectors. With s(x, m)
/// = x min(1, m / |x|):
///   b = s(w2 (s(u, V) - v), A),   j = s(4 w2 (b - a), J),   a+ = a + T j,   v+ = v + T a+,
///   w2 = min(J / 2A, 0.1 / T):
/// It is as fast as the jerk permits without overshoot, and well below the call rate.
///
/// |a| <= A and |a+ - a| <= T J always; |v| <= 1.02 V for any command.
///
/// Threads: one. Real-time: noexcept, does not allocate, O(1).
template <int N>
class ShapedVelocity {
 public:
  using Vector = Eigen::Matrix<double, N, 1>;

  /// Starts at rest. @pre bounds are positive.
  explicit ShapedVelocity(const MotionBounds& bounds) noexcept : most_(bounds) {}

  void Rest() noexcept TWIN_REALTIME {
    v_.setZero();
    a_.setZero();
  }

  /// Advances one period. @param wish  u. @param T  s, > 0. @returns v.
  const Vector& Next(const Vector& wish, double T) noexcept TWIN_REALTIME {
    const double omega = Omega(T);
    const Vector u = Limited(wish, most_.speed);
    const Vector b = Limited(omega * (u - v_), most_.acceleration);
    a_ += T * Limited(kInside * omega * (b - a_), most_.jerk);
    v_ += T * a_;
    // Ends the exponential decay with a step far below all bounds.
    const bool is_over =
        u.isZero(0) && v_.norm() < kRest * most_.speed && a_.norm() < kRest * most_.acceleration;
    if (is_over) Rest();
    return v_;
  }

  [[nodiscard]] const Vector& v() const noexcept { return v_; }
  [[nodiscard]] bool rests() const noexcept { return v_.isZero(0) && a_.isZero(0); }
  /// True if at rest apart from a negligible tail, which ends much later.
  [[nodiscard]] bool nearly_rests() const noexcept {
    return v_.norm() <= kNearly * most_.speed && a_.norm() <= kNearly * most_.acceleration;
  }
  [[nodiscard]] const MotionBounds& bounds() const noexcept { return most_; }

  /// w1, 1/s: for an outer position loop, four times slower.
  [[nodiscard]] double PositionOmega(double T) const noexcept { return Omega(T) / kInside; }

  /// s(x, most).
  [[nodiscard]] static Vector Limited(const Vector& x, double most) noexcept {
    const double norm = x.norm();
    return norm > most ? Vector(x * (most / norm)) : x;
  }

 private:
  static constexpr double kInside = 4;   ///< speed ratio of nested loops
  static constexpr double kRest = 1e-7;  ///< shares of the bounds
  static constexpr double kNearly = 2e-3;

  [[nodiscard]] double Omega(double T) const noexcept {
    return std::min(most_.jerk / (2 * most_.acceleration), 0.1 / T);
  }

  MotionBounds most_;
  Vector v_ = Vector::Zero();
  Vector a_ = Vector::Zero();
};

}  // namespace twin::teleop
