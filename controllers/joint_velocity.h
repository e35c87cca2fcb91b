#pragma once

#include "twin/control/controller.h"
#include "twin/control/registry.h"

namespace twin::controllers {

/// Parameters of a JointVelocityController, with their scenario keys in brackets.
struct JointVelocityOptions {
  double K = 5;  ///< correction, 1/s, in [0, 50] [K]
  /// Largest distance of a joint from the path's first point, rad, in (0, 0.1] [start_tolerance].
  double start_tolerance_rad = 0.02;
  /// Largest distance of a joint's reference from the goal at the end, rad, in (0, 0.1]
  /// [goal_tolerance].
  double goal_tolerance_rad = 1e-4;
  /// Time after the path's end at which the motion finishes in any case, in [0, 60] s [goal_time].
  Duration goal_time = std::chrono::seconds(5);
};

/// Follows a trajectory by joint velocities, with feedback of the position error:
///   dq_c = dq*(t) + K (q*(t) - q_d),    t since the first update,
/// q_d is the robot's own reference, the integral of the velocities that it took: errors from lost
/// commands and from the start decay as exp(-K t), whereas they stay with joint_trajectory on this
/// interface. This interface has no reference generator, so the correction must not start with a
/// step: over the first second K rises from 0 to its value by minimum jerk.
///
/// End: after the path, once q_d is within goal_tolerance, or after goal_time, the command is 0 and
/// `finished` is set.
///
/// Threads: all calls from the controller loop's thread. Real-time: Update() is noexcept, O(log
/// points), does not allocate.
class JointVelocityController final : public control::Controller {
 public:
  explicit JointVelocityController(const control::ControllerRequest& request,
                                   const JointVelocityOptions& options = {});

  [[nodiscard]] control::CommandInterface command_interface() const noexcept override {
    return control::CommandInterface::kJointVelocity;
  }
  /// @throws InputError naming place, key, value and range.
  void Configure(control::ParameterReader& parameters) override;
  /// @throws InputError naming joint, q_d, first point and cure if a joint is farther than
  /// start_tolerance_rad from the path's first point, or its q_d is not a number.
  void Activate(const RobotState& state, Time now) override;
  void Update(const RobotState& state, Time now,
              control::ControllerOutput& output) noexcept TWIN_REALTIME override;
  void Deactivate() noexcept override { is_running_ = false; }

 private:
  [[nodiscard]] bool IsThere(const RobotState& state) const noexcept;

  const reference::Trajectory& trajectory_;
  JointVelocityOptions options_;
  bool is_running_ = false;  ///< the members below are valid
  bool is_finished_ = false;
  Time start_{};  ///< `now` of the first update
};

}  // namespace twin::controllers
