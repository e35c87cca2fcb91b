#pragma once

#include "twin/control/controller.h"
#include "twin/core/joint_vector.h"
#include "twin/reference/trajectory.h"

namespace twin::controllers {

/// How a JointTrajectoryController gives the path.
struct JointTrajectoryOptions {
  control::CommandInterface command_interface = control::CommandInterface::kJointPosition;
  /// Position and pose interface only: give the path's own velocity with each position. Otherwise
  /// it is formed where the command is deposited, from successive positions and their times.
  bool give_velocity = false;
};

/// Follows a trajectory in its own time, open loop:
///   (q, dq, ddq)(now) = trajectory(now - t_0),   t_0 = `now` of the first Update after Activate.
/// A late or skipped update delays nothing: the next one is where the path is by then. The robot's
/// own position loop does the tracking. On the velocity interface the command is dq, and the path's
/// position is for the record: a start off the path stays an offset. On the pose interface the
/// command is the pose of the end effector on the path, O_T_EE(q); the null space is the robot's
/// own, so the joints need not be where the path has them.
///
/// After the end the goal is given at rest and `finished` is set, for as long as Update is called.
///
/// Threads: all calls from the controller loop's thread. Real-time: Update() is noexcept, O(log
/// points), allocates nothing.
class JointTrajectoryController final : public control::Controller {
 public:
  explicit JointTrajectoryController(reference::Trajectory trajectory,
                                     const JointTrajectoryOptions& options = {});

  [[nodiscard]] control::CommandInterface command_interface() const noexcept override {
    return options_.command_interface;
  }

  /// Takes give_velocity. @throws InputError as ParameterReader::Bool.
  void Configure(control::ParameterReader& parameters) override;

  /// @throws InputError naming the joint, its q_d, the first point and the cure when a joint is
  /// further than reference::kStartTolerance from the path's first point (or q_d is not a number).
  void Activate(const RobotState& state, Time now) override;

  void Update(const RobotState& state, Time now,
              control::ControllerOutput& output) noexcept TWIN_REALTIME override;

  void Deactivate() noexcept override { is_running_ = false; }

  [[nodiscard]] const reference::Trajectory& trajectory() const noexcept { return trajectory_; }

 private:
  reference::Trajectory trajectory_;
  JointTrajectoryOptions options_;
  Transform F_T_EE_ = kIdentityTransform;  ///< as of Activate()
  bool is_running_ = false;                ///< start_ is set
  Time start_{};                           ///< t_0
};

}  // namespace twin::controllers
