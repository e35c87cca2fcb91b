#pragma once

#include <cstdint>
#include <string>

#include "controllers/pose_reference.h"
#include "twin/control/controller.h"
#include "twin/control/registry.h"

namespace twin::controllers {

/// Parameters of a CartesianPoseController, with their scenario keys in brackets. K_P and alpha are
/// the paper's.
struct CartesianPoseOptions {
  Vector6 K_P{10, 10, 10, 10, 10, 10};  ///< 1/s, each in [0, 100] [K_P, one for all axes]
  double alpha = 1e-6;                  ///< damping, m^2 and rad^2, in [0, 1] [alpha]
  /// Time after the path's end to reach the goal, in [0, 60] s [goal_time].
  Duration goal_time = std::chrono::seconds(2);
};

/// Follows an end-effector path through the joint position interface by damped least squares, the
/// paper's controller of pick and place:
///   dq_c = (J^T J + alpha I)^-1 J^T (K_P e + dx_d),    q_c = int dq_c dt,
///   e    = x_d - x(q_c) = [p_d - p; log(R_d R^T)],
/// J and x = (R, p) are the end effector's Jacobian (base axes) and pose at the commanded joints;
/// q_c(0) is the q_d of the robot's state. The loop closes through the model only, as the paper's
/// text can be read: an initial error decays as exp(-K_P t), and the robot tracks q_c. A step from
/// t_1 to t_2 uses e at t_1 and dx_d at its midpoint, which avoids lag. In a step T the arm's
/// curvature causes an error of T^2 a / 2, which K_P corrects; T a / (2 K_P) remains, 50 um at 1
/// m/s^2 and 1 kHz. dq_c is commanded with q_c as its velocity.
///
/// The controller does not limit joint accelerations. Behind the reference generator, with two
/// drifting 1 kHz clocks, they must stay below a fifth of the limits (the range of the paper's
/// guarantee); the default poses of scenarios do.
///
/// Null space: dq_c is the smallest joint motion, so the joints do not return along a closed path
/// in general. Singularities: alpha = 1e-6 has no effect above singular values of about 1e-2 and
/// lets dq_c grow to |dx_d| / (2 sqrt(alpha)) = 500 rad/m. Limits: the law does not bound q_c. The
/// controller therefore sets `failed` when a joint would exceed its speed limit or could no longer
/// stop 0.01 rad short of the end of its range, and when the goal is not reached in goal_time.
/// Explain() gives joint, value and bound.
///
/// End: after the path, once e is within 1e-5 m and 1e-5 rad, q_c holds with dq_c = 0 and
/// `finished` is set. This stop is a step of K_P 1e-5 m/s.
///
/// Threads: all calls from the controller loop's thread. Real-time: Update() is noexcept and does
/// not allocate.
class CartesianPoseController final : public control::Controller {
 public:
  explicit CartesianPoseController(const control::ControllerRequest& request,
                                   const CartesianPoseOptions& options = {});

  [[nodiscard]] control::CommandInterface command_interface() const noexcept override {
    return control::CommandInterface::kJointPosition;
  }
  /// @throws InputError naming place, key, value and range.
  void Configure(control::ParameterReader& parameters) override;
  /// @throws InputError as PoseReference::Begin.
  void Activate(const RobotState& state, Time now) override;
  void Update(const RobotState& state, Time now,
              control::ControllerOutput& output) noexcept TWIN_REALTIME override;
  void Deactivate() noexcept override { is_running_ = false; }
  [[nodiscard]] bool follows_pose() const noexcept override { return true; }
  [[nodiscard]] std::string Explain() const override;

 private:
  enum class Failure : std::uint8_t { kNone, kVelocity, kPosition, kGoal };

  /// Integrates over a step. @param from, to  since the start of the motion.
  void Step(Duration from, Duration to) noexcept;
  [[nodiscard]] bool IsInRange(std::size_t joint, double q) const noexcept;
  void Fail(Failure failure, std::size_t joint, double value, Duration at) noexcept;

  const model::ArmModel& arm_;
  JointLimits limits_;
  CartesianPoseOptions options_;
  PoseReference reference_;
  JointVector q_c_{};
  JointVector dq_c_{};
  bool is_running_ = false;  ///< start_ is valid
  bool is_finished_ = false;
  Time start_{};        ///< `now` of the first update
  Duration elapsed_{};  ///< of the last update, after start_

  Failure failure_ = Failure::kNone;
  std::size_t failed_joint_ = 0;
  double failed_value_ = 0;
  Duration failed_at_{};
};

}  // namespace twin::controllers
