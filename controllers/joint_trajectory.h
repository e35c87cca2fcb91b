#pragma once

#include "twin/control/controller.h"
#include "twin/core/joint_vector.h"
#include "twin/reference/trajectory.h"

namespace twin::controllers {

/// Options of a JointTrajectoryController.
struct JointTrajectoryOptions {
  control::CommandInterface command_interface = control::CommandInterface::kJointPosition;
  /// Position and pose interface only: command the path's own velocity with each position. If
  /// false, it is formed where the command is deposited, from successive positions and their times.
  bool give_velocity = false;
};

/// Follows a trajectory on its own clock, open loop:
///   (q, dq, ddq)(now) = trajectory(now - t_0),   t_0 = `now` of the first Update after Activate.
/// A late or skipped update causes no lag: the next one uses the path's current point. The robot's
/// position loop tracks the command. Velocity interface: commands dq; the path's position is only
/// recorded, and a start off the path stays as an offset. Pose interface: commands the end-effector
/// pose on the path, O_T_EE(q); the robot resolves the null space, so the joints may differ from
/// the path's.
///
/// After the end, every Update commands the goal at rest and sets `finished`.
///
/// Threads: all calls from the controller loop's thread. Real-time: Update() is noexcept, O(log
/// points), does not allocate.
class JointTrajectoryController final : public control::Controller {
 public:
  explicit JointTrajectoryController(reference::Trajectory trajectory,
                                     const JointTrajectoryOptions& options = {});

  [[nodiscard]] control::CommandInterface command_interface() const noexcept override {
    return options_.command_interface;
  }

  /// Reads give_velocity. @throws InputError as ParameterReader::Bool.
  void Configure(control::ParameterReader& parameters) override;

  /// @throws InputError naming joint, q_d, first point and cure if a joint is farther than
  /// reference::kStartTolerance from the path's first point, or its q_d is not a number.
  void Activate(const RobotState& state, Time now) override;

  void Update(const RobotState& state, Time now,
              control::ControllerOutput& output) noexcept TWIN_REALTIME override;

  void Deactivate() noexcept override { is_running_ = false; }

  [[nodiscard]] const reference::Trajectory& trajectory() const noexcept { return trajectory_; }

 private:
  reference::Trajectory trajectory_;
  JointTrajectoryOptions options_;
  Transform F_T_EE_ = kIdentityTransform;  ///< at Activate()
  bool is_running_ = false;                ///< start_ is valid
  Time start_{};                           ///< t_0
};

}  // namespace twin::controllers
