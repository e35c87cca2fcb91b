#pragma once

#include "twin/core/joint_vector.h"
#include "twin/core/realtime.h"
#include "twin/core/robot_state.h"
#include "twin/teleop/teleoperator_config.h"

namespace twin::teleop {

/// The robot's end of what an operator feels: the environment's wrench on the end effector, at the
/// stiffness frame,
///   f = low-pass( -scale (F - dead zone) ),   F = O_F_ext_hat_K, or K_F_ext_hat_K,
/// limited by norm. A first-order low-pass; the dead zone shortens force and torque by what the
/// observer tells of a free arm.
///
/// Threads: one. Real-time: noexcept, allocates nothing, O(1).
class ReflectedWrench {
 public:
  explicit ReflectedWrench(const FeedbackConfig& config) noexcept : config_(config) {}

  void Reset() noexcept TWIN_REALTIME { f_ = {}; }

  /// @param in_tool_frame  in axes of K, else of the base. @param is_felt  false: the wrench fades.
  /// @param T  period, s. @returns f, N and Nm.
  const Vector6& Next(const RobotState& state, bool in_tool_frame, bool is_felt,
                      double T) noexcept TWIN_REALTIME;

 private:
  FeedbackConfig config_;
  Vector6 f_{};
};

/// The operator's end: lets only so much energy out at the handle as was put in there, whatever
/// the wire and the robot behind it do. Time-domain passivity observer and controller at one port,
/// per axis i. With x the handle's place, f the wrench at it (on the hand) that was held since the
/// call before,
///   E_i(k) = E_i(k-1) - f_i(k-1) (x_i(k) - x_i(k-1)),   E_i(0) = reserve      (J, exact: f is
///   held)
/// and f_c the wrench that came:
///   f_i = f_c,i                            E_i > 0, and it opposes the motion, f_c,i dx_i < 0
///   f_i = f_c,i min(1, 4 E_i / reserve)    E_i > 0, and it goes with the motion, or there is none
///   f_i = -d_i v_i, within the limits      in debt, E_i <= 0: a damper that pays it back,
///   d_i = min(-E_i / (T v_i^2), most damping);
/// dx_i = x_i(k) - x_i(k-1), the motion since the call before, v_i = dx_i / T.
/// So the energy that is given is bounded by the reserve, but for what a hand gets that turns
/// around within one period: |f| |dx| of that period. What the delay would make of it is taken out
/// where it would be felt, without knowing the delay. The damping is limited to what a light
/// handle bears: one that a period's damping turns around would get energy from it.
///
/// Source: Hannaford, Ryu, "Time-Domain Passivity Control of Haptic Interfaces", IEEE Transactions
/// on Robotics and Automation 18 (2002). The reserve and the fading in place of a switch are our
/// decisions.
///
/// Threads: one. Real-time: noexcept, allocates nothing, O(1).
class PassivePort {
 public:
  explicit PassivePort(const FeedbackConfig& config) noexcept;

  /// One look at the handle. @param handle  x, m and rad. @param wrench  f_c, N and Nm.
  /// @param T  since the last look, s, > 0. @returns f.
  const Vector6& Next(const Vector6& handle, const Vector6& wrench,
                      double T) noexcept TWIN_REALTIME;

  /// The handle has another origin: what it seems to have moved is no work.
  void Recentre(const Vector6& handle) noexcept TWIN_REALTIME;

  /// E less the reserve: what was put in less what came out, J per axis.
  [[nodiscard]] Vector6 energy() const noexcept;
  /// The least that any axis' energy() has been, J.
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
