#pragma once

#include <numbers>
#include <optional>

#include "controllers/pose_reference.h"
#include "controllers/soft_start.h"
#include "twin/control/controller.h"
#include "twin/control/controller_request.h"
#include "twin/model/payload.h"

namespace twin::controllers {

/// Parameters of a ComplianceController; in brackets their keys in a scenario. The defaults are the
/// paper's stiff case; its compliant one: 100 N/m and 10 Ns/m, 10 Nm/rad and 5 Nms/rad.
struct ComplianceOptions {
  /// Along (N/m, in [0, 5000]) and about (Nm/rad, in [0, 500]) the base's axes
  /// [stiffness: {translation, rotation}].
  Vector6 K_P{1000, 1000, 1000, 100, 100, 100};
  /// Ns/m in [0, 1000], Nms/rad in [0, 100] [damping: {translation, rotation}].
  Vector6 K_D{100, 100, 100, 10, 10, 10};
  double k_0 = 1.0;  ///< of the null space, Nm/rad, in [0, 100] [k0]
  /// Where the null space pulls the joints, rad [q0].
  JointVector q_0{0, 0, 0, -std::numbers::pi / 2, 0, 107 * std::numbers::pi / 180, 0};
  bool coriolis = true;  ///< C dq is added [coriolis_compensation]
  /// Share of the joints' friction that is added, in [0, 1]. Absent: what the robot leaves; more is
  /// refused [friction_compensation].
  std::optional<double> friction;
  Duration soft_start = std::chrono::milliseconds(100);     ///< in [0, 10] s
  Duration settling_time = std::chrono::milliseconds(500);  ///< at rest in the end, in [0, 60] s
};

/// Makes the end effector a spring and damper about its reference, by joint torques: the paper's
/// compliance controller,
///   tau_J_d = J^T (K_P e + K_D de) + C(q, dq) dq + f(dq) + (I - J^T J#) tau_0 + f(t) b,
///   e   = x_d - x = [p_d - p; log(R_d R^T)],   de = dx_d - J dq,
///   tau_0 = k_0 (q_0 - q) - 2 sqrt(k_0) dq,    J# = (J J^T)^-1 J, the pseudo-inverse of J^T.
/// J is the Jacobian of the end effector in base axes, x = (R, p) its pose at the measured q. The
/// orientation error is a rotation vector in base axes: its length the angle, its direction the
/// axis; for small errors the same as roll, pitch, yaw about x, y, z. It turns the shortest way.
///
/// g is the robot's part: it adds gravity to every torque. So is what it makes up for of friction
/// (onboard.friction_compensation): f(dq) here is the share that is left of tau_f of
/// model/joint_friction.h. C dq is nobody's but ours. Model and payload as the robot has them (its
/// state's end effector and load).
///
/// At standstill the deflection under a constant force F is F / K_P along each axis, to first
/// order, but for dry friction (and the null space, whose torque reaches the end effector only by
/// inertia). J# is damped: J J^T + 1e-6 I (m^2, rad^2), which takes part only where the arm is
/// singular; there a share of tau_0 acts along the direction that is lost.
///
/// The motion lasts as long as its path, or as whoever leads wants, and settling_time longer; then
/// it is finished. f(t) b: see
/// SoftStart. Nothing bounds the torque's rate beyond that: a reference that jumps, or a force that
/// does, may be too much for the robot; tick.limiter bounds it.
///
/// Threads: all calls from the controller loop's thread. Real-time: Update() is noexcept and
/// allocates nothing.
class ComplianceController final : public control::Controller {
 public:
  explicit ComplianceController(const control::ControllerRequest& request,
                                const ComplianceOptions& options = {});

  [[nodiscard]] control::CommandInterface command_interface() const noexcept override {
    return control::CommandInterface::kTorque;
  }
  /// The options, and PoseReference's. @throws InputError naming place, key, value and range.
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
  const double friction_left_;  ///< share that the robot does not make up for
  ComplianceOptions options_;
  PoseReference reference_;
  SoftStart soft_start_;
  model::Payload payload_;        ///< as of Activate()
  bool is_running_ = false;       ///< start_ is set
  Time start_{};                  ///< `now` of the first update
  std::optional<Duration> over_;  ///< since the start: when the reference came to its end
};

}  // namespace twin::controllers
