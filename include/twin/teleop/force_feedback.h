#pragma once

#include "twin/core/joint_vector.h"
#include "twin/core/realtime.h"
#include "twin/core/robot_state.h"
#include "twin/teleop/teleoperator_config.h"

namespace twin::teleop {

/// The robot's side of force feedback: the external wrench on the end effector, at the stiffness
/// frame,
///   f = low-pass( -scale (F - dead zone) ),   F = O_F_ext_hat_K, or K_F_ext_hat_K,
/// with a bounded norm. The low-pass is first-order; the dead zone shortens force and torque by the
/// observer's residual on a free arm.
///
/// Threads: one. Real-time: noexcept, does not allocate, O(1).
class ReflectedWrench {
 public:
  explicit ReflectedWrench(const FeedbackConfig& config) noexcept : config_(config) {}

  void Reset() noexcept TWIN_REALTIME { f_ = {}; }

  /// @param in_tool_frame  axes of K, else of the base. @param is_felt  false: the wrench fades
  /// out.
  /// @param T  period, s. @returns f, N and Nm.
  const Vector6& Next(const RobotState& state, bool in_tool_frame, bool is_felt,
                      double T) noexcept TWIN_REALTIME;

 private:
  FeedbackConfig config_;
  Vector6 f_{};
};

/// The operator's side: the handle returns no more energy than was put in, whatever the wire and
/// the robot do. Time-domain passivity observer and controller at one port, per axis i. With the
/// handle's position x and the wrench f on the hand, held since the previous call,
///   E_i(k) = E_i(k-1) - f_i(k-1) (x_i(k) - x_i(k-1)),   E_i(0) = reserve      (J, exact)
/// and the received wrench f_c:
///   f_i = f_c,i                            E_i > 0, f_c opposes the motion: f_c,i dx_i < 0
///   f_i = f_c,i min(1, 4 E_i / reserve)    E_i > 0, f_c acts along the motion, or no motion
///   f_i = -d_i v_i, within the limits      E_i <= 0: a damper repays the debt,
///   d_i = min(-E_i / (T v_i^2), largest damping);
/// dx_i = x_i(k) - x_i(k-1), v_i = dx_i / T. The reserve thus bounds the energy that the port
/// gives, except for a reversal within one period, which adds that period's |f| |dx|. Energy that
/// the delay creates is removed at the handle, without knowledge of the delay. The damping is
/// limited to what a light handle tolerates: a handle that one period of damping reverses would
/// gain energy.
///
/// Source: Hannaford, Ryu, "Time-Domain Passivity Control of Haptic Interfaces", IEEE Transactions
/// on Robotics and Automation 18 (2002). The reserve, and fading instead of switching, are
/// decisions.
///
/// Threads: one. Real-time: noexcept, does not allocate, O(1).
class PassivePort {
 public:
  explicit PassivePort(const FeedbackConfig& config) noexcept;

  /// One sample of the handle. @param handle  x, m and rad. @param wrench  f_c, N and Nm.
  /// @param T  since the last sample, s, > 0. @returns f.
  const Vector6& Next(const Vector6& handle, const Vector6& wrench,
                      double T) noexcept TWIN_REALTIME;

  /// Sets a new origin of the handle without counting its displacement as work.
  void Recentre(const Vector6& handle) noexcept TWIN_REALTIME;

  /// E minus the reserve: energy put in minus energy given, J per axis.
  [[nodiscard]] Vector6 energy() const noexcept;
  /// Minimum of energy() over all axes and calls, J.
  [[nodiscard]] double least_energy() const noexcept { return least_; }

 private:
  FeedbackConfig config_;
  bool has_handle_ = false;
  Vector6 handle_{};
  Vector6 f_{};
  Vector6 E_{};
  double least_ = 0;
};

}  // namespace twin::teleop
