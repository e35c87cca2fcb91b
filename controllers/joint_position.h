#pragma once

#include "twin/control/controller.h"
#include "twin/control/registry.h"

namespace twin::controllers {

/// Parameters of a JointPositionController, with their scenario keys in brackets.
struct JointPositionOptions {
  /// Largest distance of a joint from the path's first point, rad, in (0, 0.1] [start_tolerance].
  double start_tolerance_rad = 0.1;
  /// Time over which the initial distance fades, in [0.1, 60] s [blend].
  Duration blend = std::chrono::seconds(2);
};

/// Commands a trajectory's joint positions, starting exactly at the robot's reference:
///   q_c  = q*(t) + (1 - s(t / T)) (q_d(0) - q*(0)),    t since the first update, T the blend,
///   dq_c = dq*(t) - ds(t / T) / T (q_d(0) - q*(0)),
///   s(x) = 10 x^3 - 15 x^4 + 6 x^5 in [0, 1], then 1: minimum jerk.
/// The velocity is commanded with the position, so jitter of the loop's clock is not
/// differentiated. An offset d adds up to 1.875 d / T of velocity, 5.8 d / T^2 of acceleration and
/// 60 d / T^3 of jerk to the path's: 0.09 rad/s, 0.15 rad/s^2 and 0.75 rad/s^3 at 0.1 rad. After
/// both path and blend it commands the goal at rest and sets `finished`. joint_trajectory does the
/// same without the blend and derives the velocity from the deposits.
///
/// Threads: all calls from the controller loop's thread. Real-time: Update() is noexcept, O(log
/// points), does not allocate.
class JointPositionController final : public control::Controller {
 public:
  explicit JointPositionController(const control::ControllerRequest& request,
                                   const JointPositionOptions& options = {});

  [[nodiscard]] control::CommandInterface command_interface() const noexcept override {
    return control::CommandInterface::kJointPosition;
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
  const reference::Trajectory& trajectory_;
  JointPositionOptions options_;
  bool is_running_ = false;  ///< the members below are valid
  Time start_{};             ///< `now` of the first update
  JointVector offset_{};     ///< q_d(0) - q*(0), rad
};

}  // namespace twin::controllers
