#pragma once

#include "twin/control/controller.h"
#include "twin/control/controller_request.h"

namespace twin::controllers {

/// Parameters of a JointPositionController; in brackets their keys in a scenario.
struct JointPositionOptions {
  /// Largest distance of a joint from the path's first point, rad, in (0, 0.1] [start_tolerance].
  double start_tolerance_rad = 0.1;
  /// Time over which that distance is taken in, in [0.1, 60] s [blend].
  Duration blend = std::chrono::seconds(2);
};

/// Gives a trajectory's joint positions, beginning exactly where the robot's reference is:
///   q_c  = q*(t) + (1 - s(t / T)) (q_d(0) - q*(0)),    t since the first update, T the blend,
///   dq_c = dq*(t) - ds(t / T) / T (q_d(0) - q*(0)),
///   s(x) = 10 x^3 - 15 x^4 + 6 x^5 in [0, 1], then 1: minimum jerk.
/// The velocity goes with the position, so no noise of the loop's own clock is differentiated. An
/// offset d adds up to 1.875 d / T of velocity, 5.8 d / T^2 of acceleration and 60 d / T^3 of jerk
/// to the path's own: 0.09 rad/s, 0.15 rad/s^2 and 0.75 rad/s^3 at 0.1 rad. In the end, after both
/// path and blend, the goal is given at rest and `finished` is set. joint_trajectory does the same
/// without the blend, and forms the velocity from the deposits.
///
/// Threads: all calls from the controller loop's thread. Real-time: Update() is noexcept, O(log
/// points), allocates nothing.
class JointPositionController final : public control::Controller {
 public:
  explicit JointPositionController(const control::ControllerRequest& request,
                                   const JointPositionOptions& options = {});

  [[nodiscard]] control::CommandInterface command_interface() const noexcept override {
    return control::CommandInterface::kJointPosition;
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
  const reference::Trajectory& trajectory_;
  JointPositionOptions options_;
  bool is_running_ = false;  ///< what follows is of the running motion
  Time start_{};             ///< `now` of the first update
  JointVector offset_{};     ///< q_d(0) - q*(0), rad
};

}  // namespace twin::controllers
