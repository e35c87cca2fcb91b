#pragma once

#include "twin/control/controller.h"
#include "twin/reference/trajectory.h"

namespace twin::controllers {

/// Parameters of a JointEffortController. The gains are the paper's, section on planning: P 600, I
/// 0, D 30 for joints 1 to 4, 250/0/10 for joint 5, 150/0/10 for joint 6, 50/0/5 for joint 7. The
/// rest is ours.
struct JointEffortOptions {
  JointVector K_P{600, 600, 600, 600, 250, 150, 50};  ///< Nm/rad, each in [0, 1e4]
  JointVector K_I{0, 0, 0, 0, 0, 0, 0};               ///< Nm/(rad s), each in [0, 1e4]
  JointVector K_D{30, 30, 30, 30, 10, 10, 5};         ///< Nm s/rad, each in [0, 1e3]
  /// Most that the integral may contribute, Nm, each in [0, 100]. Against wind-up: about three
  /// times the arm's dry friction, which is all the integral is for.
  JointVector integral_max{3, 3, 3, 3, 3, 2, 2};
  /// Time over which the difference to the torque before the first update fades, in [0, 10] s.
  Duration soft_start = std::chrono::milliseconds(100);
  /// Largest distance of a joint from the path's first point, rad, in (0, 0.1].
  double start_tolerance_rad = 0.02;
  /// After the path's end the arm counts as settled when every joint is this near the goal, rad, in
  /// (0, 1] ...
  double settled_distance_rad = 0.01;
  /// ... and this slow, rad/s, in (0, 1].
  double settled_speed_rad_per_s = 0.01;
  /// Time after the path's end at which the motion is finished, settled or not, in [0, 60] s.
  Duration settling_time = std::chrono::seconds(1);

  /// @throws InputError naming field, value and range.
  void Validate() const;
};

/// Follows a trajectory by joint torques, as the paper's effort-based joint trajectory controller:
///   tau_J_d = K_P (q* - q) + K_I int (q* - q) dt + K_D (dq* - dq) + f(t) b,
///   (q*, dq*)(now) = trajectory(now - t_0),   t_0 = `now` of the first Update after Activate.
/// No inertia or Coriolis torque is fed forward: the arm lags by about (M ddq + friction) / K_P.
/// Gravity is the robot's part. A late or skipped update delays nothing.
///
/// Soft start. b is the difference between the torque the robot reports at the first update and
/// what the law asks for there, f falls from 1 to 0 in a straight line over `soft_start`: the
/// motion begins with the very torque that held the arm, whatever error its own controller and the
/// start tolerance leave. Without it, 1 mrad at 600 Nm/rad would step by 600 Nm/s of the 1000
/// Nm/s that the robot takes.
///
/// Integral. Each joint's K_I int (q* - q) dt is kept within +-integral_max, so it neither winds up
/// against an obstacle nor takes long to come back. It is zero at the first update.
///
/// End. After the trajectory the goal at rest is the reference. `finished` is set once all joints
/// are settled (distance and speed in one state), or after settling_time: dry friction may hold a
/// joint off the goal by its break-away torque / K_P, up to 8 mrad at joint 7. It stays set. The
/// robot stops what then still moves. target.joint is the path, for the record.
///
/// Threads: all calls from the controller loop's thread. Real-time: Update() is noexcept, O(log
/// points), allocates nothing.
class JointEffortController final : public control::Controller {
 public:
  /// @throws InputError as JointEffortOptions::Validate.
  explicit JointEffortController(reference::Trajectory trajectory,
                                 const JointEffortOptions& options = {});

  [[nodiscard]] control::CommandInterface command_interface() const noexcept override {
    return control::CommandInterface::kTorque;
  }

  /// @throws InputError naming the joint, its measured q, the first point and the cure when a joint
  /// is further than start_tolerance_rad from the path's first point (or q is not a number).
  void Activate(const RobotState& state, Time now) override;

  void Update(const RobotState& state, Time now,
              control::ControllerOutput& output) noexcept TWIN_REALTIME override;

  void Deactivate() noexcept override { is_running_ = false; }

 private:
  void Begin(Time now) noexcept;
  [[nodiscard]] JointVector Law(const reference::JointTarget& target, const RobotState& state,
                                double dt) noexcept;
  [[nodiscard]] bool IsSettled(const RobotState& state) const noexcept;

  reference::Trajectory trajectory_;
  JointEffortOptions options_;
  bool is_running_ = false;  ///< what follows is of the running motion
  bool is_finished_ = false;
  Time start_{};            ///< t_0
  Time last_{};             ///< `now` of the last update
  JointVector integral_{};  ///< K_I int (q* - q) dt, Nm
  JointVector bump_{};      ///< b, Nm
};

}  // namespace twin::controllers
