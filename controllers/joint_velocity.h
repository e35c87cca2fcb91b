#pragma once

#include "twin/control/controller.h"
#include "twin/control/controller_request.h"

namespace twin::controllers {

/// Parameters of a JointVelocityController; in brackets their keys in a scenario.
struct JointVelocityOptions {
  double K = 5;  ///< correction, 1/s, in [0, 50] [K]
  /// Largest distance of a joint from the path's first point, rad, in (0, 0.1] [start_tolerance].
  double start_tolerance_rad = 0.02;
  /// In the end every joint's reference is this near the goal, rad, in (0, 0.1] [goal_tolerance].
  double goal_tolerance_rad = 1e-4;
  /// Time after the path's end at which the motion is finished all the same, in [0, 60] s
  /// [goal_time].
  Duration goal_time = std::chrono::seconds(5);
};

/// Follows a trajectory by joint velocities, and keeps to its positions:
///   dq_c = dq*(t) + K (q*(t) - q_d),    t since the first update,
/// q_d the robot's own reference, which is the integral of what it took: what was lost on the way,
/// and an offset of the start, decay as exp(-K t) instead of staying, as they do with
/// joint_trajectory on this interface. No reference generator stands on it, so an offset must not
/// begin with a step: in the first second K is let in by minimum jerk, from 0 to its value.
///
/// End. After the path, once q_d is within goal_tolerance, or after goal_time, the command is 0 and
/// `finished` is set.
///
/// Threads: all calls from the controller loop's thread. Real-time: Update() is noexcept, O(log
/// points), allocates nothing.
class JointVelocityController final : public control::Controller {
 public:
  explicit JointVelocityController(const control::ControllerRequest& request,
                                   const JointVelocityOptions& options = {});

  [[nodiscard]] control::CommandInterface command_interface() const noexcept override {
    return control::CommandInterface::kJointVelocity;
  }
  /// @throws InputError naming place, key, value and range.
  void Configure(control::ParameterReader& parameters) override;
  /// @throws InputError naming the joint, its q_d, the first point and the cure when a joint is
  /// further than start_tolerance_rad from the path's first point (or q_d is not a number).
  void Activate(const RobotState& state, Time now) override;
  void Update(const RobotState& state, Time now,
              control::ControllerOutput& output) noexcept TWIN_REALTIME override;
  void Deactivate() noexcept override { is_running_ = false; }

 private:
  [[nodiscard]] bool IsThere(const RobotState& state) const noexcept;

  const reference::Trajectory& trajectory_;
  JointVelocityOptions options_;
  bool is_running_ = false;  ///< what follows is of the running motion
  bool is_finished_ = false;
  Time start_{};  ///< `now` of the first update
};

}  // namespace twin::controllers
