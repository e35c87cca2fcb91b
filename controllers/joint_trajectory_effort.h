#pragma once

#include <cstdint>
#include <string>

#include "controllers/soft_start.h"
#include "twin/control/controller.h"
#include "twin/reference/trajectory.h"

namespace twin::controllers {

/// Parameters of a JointTrajectoryEffortController, with their scenario keys in brackets where they
/// differ. The gains are the paper's, section on planning: P 600, I 0, D 30 for joints 1 to 4,
/// 250/0/10 for joint 5, 150/0/10 for joint 6, 50/0/5 for joint 7. The rest is a decision.
struct JointTrajectoryEffortOptions {
  JointVector K_P{600, 600, 600, 600, 250, 150, 50};  ///< Nm/rad, each in [0, 1e4]
  JointVector K_I{0, 0, 0, 0, 0, 0, 0};               ///< Nm/(rad s), each in [0, 1e4]
  JointVector K_D{30, 30, 30, 30, 10, 10, 5};         ///< Nm s/rad, each in [0, 1e3]
  /// Bound of the integral's torque against wind-up, Nm, each in [0, 100]: about three times the
  /// arm's dry friction, which is the integral's only purpose.
  JointVector integral_max{3, 3, 3, 3, 3, 2, 2};
  /// Time over which the step from the torque before the first update fades, in [0, 10] s.
  Duration soft_start = std::chrono::milliseconds(100);
  /// Largest distance of a joint from the path's first point, rad, in (0, 0.1] [start_tolerance].
  double start_tolerance_rad = 0.02;
  /// Largest distance of a joint from the path before its end, rad, each in [0, 10]; 0: no bound.
  JointVector path_tolerance{};
  /// Largest distance of a joint from the goal at the end, rad, each in [0, 10]; 0: no bound.
  JointVector goal_tolerance{};
  /// After the path's end the arm counts as settled when every joint is this close to the goal
  /// (closer where goal_tolerance is less), rad, in (0, 1] [settled_distance] ...
  double settled_distance_rad = 0.01;
  /// ... and this slow, rad/s, in (0, 1] [stopped_velocity_tolerance].
  double settled_speed_rad_per_s = 0.01;
  /// Time after the path's end, in [0, 60] s, at which the motion finishes even if not settled, or
  /// fails its goal tolerance [goal_time].
  Duration settling_time = std::chrono::seconds(1);

  /// @throws InputError naming field, value and range.
  void Validate() const;
};

/// Follows a trajectory by joint torques, like the paper's effort-based joint trajectory
/// controller:
///   tau_J_d = K_P (q* - q) + K_I int (q* - q) dt + K_D (dq* - dq) + f(t) b,
///   (q*, dq*)(now) = trajectory(now - t_0),   t_0 = `now` of the first Update after Activate.
/// Inertia and Coriolis torques are not fed forward: the arm lags by about (M ddq + friction) /
/// K_P. The robot adds gravity. A late or skipped update causes no lag. f b: see SoftStart.
///
/// Integral: each joint's K_I int (q* - q) dt stays within +-integral_max, which prevents wind-up
/// against an obstacle and a slow return. It is zero at the first update.
///
/// End: after the trajectory the reference is the goal at rest. `finished` is set, and stays set,
/// once all joints are settled (distance and speed in one state), or after settling_time: dry
/// friction may hold a joint off the goal by its break-away torque / K_P, up to 8 mrad at joint 7.
/// The robot stops any remaining motion. target.joint is the path, for the record.
///
/// Tolerances, as in ROS 2's joint_trajectory_controller: `failed` is set if |q* - q| of a joint
/// exceeds its path_tolerance before the path's end, or its goal_tolerance after settling_time. It
/// stays set, with that moment's torque; Explain() gives joint, distance and bound. Unlike there, a
/// tolerance of 0 disables the goal check too.
///
/// Threads: all calls from the controller loop's thread. Real-time: Update() is noexcept, O(log
/// points), does not allocate.
class JointTrajectoryEffortController final : public control::Controller {
 public:
  /// @throws InputError as JointTrajectoryEffortOptions::Validate.
  explicit JointTrajectoryEffortController(reference::Trajectory trajectory,
                                           const JointTrajectoryEffortOptions& options = {});

  [[nodiscard]] control::CommandInterface command_interface() const noexcept override {
    return control::CommandInterface::kTorque;
  }

  /// Reads the options by key. @throws InputError naming place, key, value and range.
  void Configure(control::ParameterReader& parameters) override;

  /// @throws InputError naming joint, measured q, first point and cure if a joint is farther than
  /// start_tolerance_rad from the path's first point, or its q is not a number.
  void Activate(const RobotState& state, Time now) override;

  void Update(const RobotState& state, Time now,
              control::ControllerOutput& output) noexcept TWIN_REALTIME override;

  void Deactivate() noexcept override { is_running_ = false; }

  [[nodiscard]] std::string Explain() const override;

  [[nodiscard]] const JointTrajectoryEffortOptions& options() const noexcept { return options_; }

 private:
  /// A violated tolerance.
  struct Breach {
    enum class Of : std::uint8_t { kNothing, kPath, kGoal };
    Of of = Of::kNothing;
    std::size_t joint = 0;
    double distance = 0;  ///< rad
    Duration at{};        ///< since the start of the motion
  };

  void Begin(Time now) noexcept;
  [[nodiscard]] JointVector Law(const reference::JointTarget& target, const RobotState& state,
                                double dt) noexcept;
  [[nodiscard]] bool IsSettled(const RobotState& state) const noexcept;
  /// Records the first joint that is farther from q* than its tolerance, if that is not 0.
  void Judge(Breach::Of of, const JointVector& tolerance, const JointVector& q_star,
             const RobotState& state, Duration elapsed) noexcept;

  reference::Trajectory trajectory_;
  JointTrajectoryEffortOptions options_;
  SoftStart soft_start_;
  bool is_running_ = false;  ///< the members below are valid
  bool is_finished_ = false;
  Breach breach_;
  Time start_{};            ///< t_0
  Time last_{};             ///< `now` of the last update
  JointVector integral_{};  ///< K_I int (q* - q) dt, Nm
};

}  // namespace twin::controllers
