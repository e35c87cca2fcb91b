#include "controllers/gravity_hold.h"

namespace twin::controllers {

GravityHoldController::GravityHoldController(const control::ControllerRequest& request,
                                             const GravityHoldOptions& options)
    : duration_(request.trajectory.duration()),
      options_(options),
      soft_start_(options.soft_start) {}

void GravityHoldController::Configure(control::ParameterReader& p) {
  options_.K_D = p.Joints("damping", Dimension::kAngularDamping, options_.K_D, 0, 100);
  options_.soft_start =
      p.Time("soft_start", options_.soft_start, Duration::zero(), std::chrono::seconds(10));
  soft_start_ = SoftStart(options_.soft_start);
}

void GravityHoldController::Update(const RobotState& state, Time now,
                                   control::ControllerOutput& output) noexcept {
  const bool is_first = !is_running_;
  if (is_first) start_ = now;
  is_running_ = true;
  const Duration elapsed = now - start_;
  JointVector& tau = output.target.tau_J_d;
  for (std::size_t j = 0; j < kJoints; ++j) tau[j] = -options_.K_D[j] * state.dq[j];
  if (is_first) soft_start_.Begin(state, tau);
  soft_start_.AddTo(tau, elapsed);
  output.target.joint = {.q = state.q, .dq = state.dq, .ddq = {}};
  output.has_velocity = false;
  output.failed = false;
  output.finished = elapsed >= duration_;
}

}  // namespace twin::controllers
