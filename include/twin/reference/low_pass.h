#pragma once

#include <array>
#include <cstddef>

#include "twin/core/joint_vector.h"
#include "twin/core/realtime.h"

namespace twin::reference {

/// libfranka's client-side low-pass on a command, of first order:
///   y(k) = y(k-1) + gain (x(k) - y(k-1)),   gain = T / (T + 1 / (2 pi f_c)),   T = 1 ms,
/// 0.385870 at f_c = 100 Hz. y(k-1) is the last commanded value in the answered state (tau_J_d,
/// q_d, dq_d, O_T_EE_c, O_dP_EE_c or the angle of elbow_c), not a memory of the client. Behind an
/// incremental generator it therefore scales the increment: see JointReferenceGenerator. Source:
/// FCI protocol 5, low-pass filter of libfranka 0.9.2.
///
/// Threads: stateless, any. Real-time: all but the constructor; noexcept, O(1), no allocation.
class LowPass {
 public:
  /// @param cutoff_hz  f_c in [1, 1000]; 1000 is libfranka's "off": y = x.
  /// @throws InputError naming the value and the range.
  explicit LowPass(double cutoff_hz);

  /// @param x  commanded value. @param last  y(k-1), same unit. A NaN passes through.
  [[nodiscard]] double Filter(double x, double last) const noexcept TWIN_REALTIME {
    return is_on() ? last + gain_ * (x - last) : x;
  }

  /// The same per component: joints, or a twist.
  template <std::size_t kSize>
  [[nodiscard]] std::array<double, kSize> Filter(
      const std::array<double, kSize>& x,
      const std::array<double, kSize>& last) const noexcept TWIN_REALTIME {
    std::array<double, kSize> y;
    for (std::size_t i = 0; i < kSize; ++i) y[i] = Filter(x[i], last[i]);
    return y;
  }

  /// Filters the translation as above. Turns the rotation of `last` towards that of O_T_EE_c by the
  /// fraction gain() of the angle between them (slerp); orthonormal up to rounding.
  /// @param O_T_EE_c  commanded pose. @param last  O_T_EE_c of the state.
  [[nodiscard]] Transform FilterPose(const Transform& O_T_EE_c,
                                     const Transform& last) const noexcept TWIN_REALTIME;

  [[nodiscard]] bool is_on() const noexcept { return gain_ < 1; }

  /// In (0, 1]; 1 when off.
  [[nodiscard]] double gain() const noexcept { return gain_; }

 private:
  double gain_;
};

}  // namespace twin::reference
