#pragma once

#include <cstdint>
#include <string>

#include "controllers/pose_reference.h"
#include "twin/control/controller.h"
#include "twin/control/controller_request.h"

namespace twin::controllers {

/// Parameters of a CartesianPoseController; in brackets their keys in a scenario. K_P and alpha are
/// the paper's.
struct CartesianPoseOptions {
  Vector6 K_P{10, 10, 10, 10, 10, 10};  ///< 1/s, each in [0, 100] [K_P, one for all axes]
  double alpha = 1e-6;                  ///< damping, m^2 and rad^2, in [0, 1] [alpha]
  /// Time after the path's end within which the goal must be reached, in [0, 60] s [goal_time].
  Duration goal_time = std::chrono::seconds(2);
};

/// Follows a path of the end effector through the joint position interface, by damped least
/// squares: the paper's controller of pick and place,
///   dq_c = (J^T J + alpha I)^-1 J^T (K_P e + dx_d),    q_c = int dq_c dt,
///   e    = x_d - x(q_c) = [p_d - p; log(R_d R^T)],
/// J and x = (R, p) the end effector's Jacobian (base axes) and pose at the commanded joints,
/// q_c(0) the q_d of the robot's state. The loop is closed through the model alone, as the paper's
/// text can be read: an error of the start decays as exp(-K_P t), and how the arm tracks q_c is the
/// robot's own affair. A step from t_1 to t_2 takes e at t_1 and dx_d in the middle of it, so that
/// there is no lag; what a step of T misses by the arm's curvature, T^2 a / 2, K_P takes back: T a
/// / (2 K_P) is left, 50 um at 1 m/s^2 and 1 kHz. dq_c goes with q_c as its velocity.
///
/// How fast: joint accelerations are nobody's care here. Behind the reference generator with two
/// clocks of 1 kHz that drift they must stay below a fifth of the limits (the paper's promise ends
/// there); scenarios' poses are that gentle unless told otherwise.
///
/// Null space: dq_c is the smallest joint motion; the joints come back along a closed path only by
/// chance. Singularities: alpha = 1e-6 changes nothing above singular values of about 1e-2 and lets
/// dq_c grow to |dx_d| / (2 sqrt(alpha)) = 500 rad/m; limits: nothing keeps q_c inside. So both are
/// watched: `failed` is set when a joint would have to be faster than its limit, or comes within
/// 0.01 rad of the end of its range; also when the goal is not reached in goal_time. Explain() has
/// joint, value and bound.
///
/// End. After the path, once e is within 1e-5 m and 1e-5 rad, q_c stays and dq_c is 0: at rest, and
/// finished. That stop is a step of K_P 1e-5 m/s.
///
/// Threads: all calls from the controller loop's thread. Real-time: Update() is noexcept and
/// allocates nothing.
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

  /// Integrates over a step. @param from, to  since the motion began.
  void Step(Duration from, Duration to) noexcept;
  void Fail(Failure failure, std::size_t joint, double value, Duration at) noexcept;

  const model::ArmModel& arm_;
  JointLimits limits_;
  CartesianPoseOptions options_;
  PoseReference reference_;
  JointVector q_c_{};
  JointVector dq_c_{};
  bool is_running_ = false;  ///< start_ is set
  bool is_finished_ = false;
  Time start_{};        ///< `now` of the first update
  Duration elapsed_{};  ///< of the last update, since start_

  Failure failure_ = Failure::kNone;
  std::size_t failed_joint_ = 0;
  double failed_value_ = 0;
  Duration failed_at_{};
};

}  // namespace twin::controllers
