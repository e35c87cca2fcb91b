#pragma once

#include <numbers>
#include <optional>

#include "controllers/pose_reference.h"
#include "controllers/soft_start.h"
#include "twin/control/controller.h"
#include "twin/control/registry.h"
#include "twin/model/mass_properties.h"

namespace twin::controllers {

/// Parameters of a ComplianceController, with their scenario keys in brackets. The defaults are the
/// paper's stiff case; its compliant case has 100 N/m and 10 Ns/m, 10 Nm/rad and 5 Nms/rad.
struct ComplianceOptions {
  /// Along (N/m, in [0, 5000]) and about (Nm/rad, in [0, 500]) the base's axes
  /// [stiffness: {translation, rotation}].
  Vector6 K_P{1000, 1000, 1000, 100, 100, 100};
  /// Ns/m in [0, 1000], Nms/rad in [0, 100] [damping: {translation, rotation}].
  Vector6 K_D{100, 100, 100, 10, 10, 10};
  double k_0 = 1.0;  ///< of the null space, Nm/rad, in [0, 100] [k0]
  /// Joint positions toward which the null space pulls, rad [q0].
  JointVector q_0{0, 0, 0, -std::numbers::pi / 2, 0, 107 * std::numbers::pi / 180, 0};
  bool coriolis = true;  ///< adds C dq [coriolis_compensation]
  /// Share of the joint friction to add, in [0, 1]. Absent: all that the robot leaves; a larger
  /// share is refused [friction_compensation].
  std::optional<double> friction;
  Duration soft_start = std::chrono::milliseconds(100);     ///< in [0, 10] s
  Duration settling_time = std::chrono::milliseconds(500);  ///< at rest after the end, in [0, 60] s
};

/// Makes the end effector a spring and damper about its reference by joint torques, the paper's
/// compliance controller:
///   tau_J_d = J^T (K_P e + K_D de) + C(q, dq) dq + f(dq) + (I - J^T J#) tau_0 + f(t) b,
///   e   = x_d - x = [p_d - p; log(R_d R^T)],   de = dx_d - J dq,
///   tau_0 = k_0 (q_0 - q) + 2 sqrt(k_0) (dq_0 - dq),    J# = (J J^T)^-1 J, the pseudo-inverse of
///   J^T.
/// q_0 is constant (dq_0 = 0), but follows the posture of a live reference that has one.
/// J is the Jacobian of the end effector in base axes, x = (R, p) its pose at the measured q. The
/// orientation error is a rotation vector (angle times axis) in base axes, along the shortest
/// rotation; for small errors it equals roll, pitch, yaw about x, y, z.
///
/// The robot adds gravity to every torque, and its own friction compensation
/// (onboard.friction_compensation): f(dq) here is the remaining share of tau_f in
/// model/arm_model.h. The robot does not add C dq. Model and payload are the robot's (end
/// effector and load in its state).
///
/// At standstill a constant force F deflects each axis by F / K_P, to first order, apart from dry
/// friction (and the null space, whose torque acts on the end effector only through inertia). J# is
/// damped: J J^T + 1e-6 I (m^2, rad^2), which matters only near singularities; there a share of
/// tau_0 acts along the lost direction. With a live reference's posture, 1e-2 I: where the end
/// effector's springs grow too weak to hold a joint, k_0 holds it.
///
/// The motion lasts as long as its path, or until the operator ends it, plus settling_time; then it
/// is finished. f(t) b: see SoftStart. The torque rate is not bounded otherwise: a jump of the
/// reference or of a contact force may exceed the robot's limit. tick.limiter bounds it.
///
/// Threads: all calls from the controller loop's thread. Real-time: Update() is noexcept and does
/// not allocate.
class ComplianceController final : public control::Controller {
 public:
  explicit ComplianceController(const control::ControllerRequest& request,
                                const ComplianceOptions& options = {});

  [[nodiscard]] control::CommandInterface command_interface() const noexcept override {
    return control::CommandInterface::kTorque;
  }
  /// Reads the options and PoseReference's. @throws InputError naming place, key, value and range.
  void Configure(control::ParameterReader& parameters) override;
  /// @throws InputError as PoseReference::Begin.
  void Activate(const RobotState& state, Time now) override;
  void Update(const RobotState& state, Time now,
              control::ControllerOutput& output) noexcept TWIN_REALTIME override;
  void Deactivate() noexcept override { is_running_ = false; }
  [[nodiscard]] bool follows_pose() const noexcept override { return true; }

  [[nodiscard]] const ComplianceOptions& options() const noexcept { return options_; }

 private:
  [[nodiscard]] JointVector Law(const RobotState& state,
                                const reference::PoseTarget& target) const noexcept;

  const model::ArmModel& arm_;
  const double friction_left_;  ///< share that the robot does not compensate
  ComplianceOptions options_;
  PoseReference reference_;
  SoftStart soft_start_;
  model::Payload payload_;        ///< at Activate()
  bool is_running_ = false;       ///< start_ is valid
  Time start_{};                  ///< `now` of the first update
  std::optional<Duration> over_;  ///< time after start_ at which the reference ended
};

}  // namespace twin::controllers
