#pragma once

#include "controllers/soft_start.h"
#include "twin/control/controller.h"
#include "twin/control/registry.h"

namespace twin::controllers {

/// Parameters of a GravityHoldController, with their scenario keys in brackets.
struct GravityHoldOptions {
  JointVector K_D{};                                     ///< Nm s/rad, each in [0, 100] [damping]
  Duration soft_start = std::chrono::milliseconds(100);  ///< in [0, 10] s
};

/// Lets the arm float: the robot compensates gravity in every torque, and the controller adds only
/// damping,
///   tau_J_d = -K_D dq + f(t) b,
/// f b: see SoftStart. No damping by default; the share of joint friction that the robot does not
/// compensate slows the arm. A load unknown to the robot sinks. The arm's motion is
///   M ddq + C dq + K_D dq = tau_ext - friction.
///
/// Lasts as long as the motion's trajectory and ignores its points; then it is finished.
///
/// Threads: all calls from the controller loop's thread. Real-time: Update() is noexcept and does
/// not allocate.
class GravityHoldController final : public control::Controller {
 public:
  explicit GravityHoldController(const control::ControllerRequest& request,
                                 const GravityHoldOptions& options = {});

  [[nodiscard]] control::CommandInterface command_interface() const noexcept override {
    return control::CommandInterface::kTorque;
  }
  /// @throws InputError naming place, key, value and range.
  void Configure(control::ParameterReader& parameters) override;
  void Activate(const RobotState& /*state*/, Time /*now*/) override { is_running_ = false; }
  void Update(const RobotState& state, Time now,
              control::ControllerOutput& output) noexcept TWIN_REALTIME override;
  void Deactivate() noexcept override { is_running_ = false; }

 private:
  Duration duration_;
  GravityHoldOptions options_;
  SoftStart soft_start_;
  bool is_running_ = false;  ///< start_ is valid
  Time start_{};             ///< `now` of the first update
};

}  // namespace twin::controllers
