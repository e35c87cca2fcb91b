#pragma once

#include <cstdint>
#include <string>

#include "controllers/soft_start.h"
#include "twin/control/controller.h"
#include "twin/reference/trajectory.h"

namespace twin::controllers {

/// Parameters of a JointTrajectoryEffortController; in brackets their keys in a scenario, where
/// they differ. The gains are the paper's, section on planning: P 600, I 0, D 30 for joints 1 to 4,
/// 250/0/10 for joint 5, 150/0/10 for joint 6, 50/0/5 for joint 7. The rest is ours.
struct JointTrajectoryEffortOptions {
  JointVector K_P{600, 600, 600, 600, 250, 150, 50};  ///< Nm/rad, each in [0, 1e4]
  JointVector K_I{0, 0, 0, 0, 0, 0, 0};               ///< Nm/(rad s), each in [0, 1e4]
  JointVector K_D{30, 30, 30, 30, 10, 10, 5};         ///< Nm s/rad, each in [0, 1e3]
  /// Most that the integral may contribute, Nm, each in [0, 100]. Against wind-up: about three
  /// times the arm's dry friction, which is all the integral is for.
  JointVector integral_max{3, 3, 3, 3, 3, 2, 2};
  /// Time over which the difference to the torque before the first update fades, in [0, 10] s.
  Duration soft_start = std::chrono::milliseconds(100);
  /// Largest distance of a joint from the path's first point, rad, in (0, 0.1] [start_tolerance].
  double start_tolerance_rad = 0.02;
  /// Largest distance of a joint from the path on its way, rad, each in [0, 10]; 0: as far as it
  /// likes.
  JointVector path_tolerance{};
  /// Largest distance of a joint from the goal in the end, rad, each in [0, 10]; 0: whatever it is,
  /// the motion is finished.
  JointVector goal_tolerance{};
  /// After the path's end the arm counts as settled when every joint is this near the goal (nearer
  /// where goal_tolerance is less), rad, in (0, 1] [settled_distance] ...
  double settled_distance_rad = 0.01;
  /// ... and this slow, rad/s, in (0, 1] [stopped_velocity_tolerance].
  double settled_speed_rad_per_s = 0.01;
  /// Time after the path's end at which the motion is finished, settled or not, or has failed for
  /// its goal tolerance, in [0, 60] s [goal_time].
  Duration settling_time = std::chrono::seconds(1);

  /// @throws InputError naming field, value and range.
  void Validate() const;
};

/// Follows a trajectory by joint torques, as the paper's effort-based joint trajectory controller:
///   tau_J_d = K_P (q* - q) + K_I int (q* - q) dt + K_D (dq* - dq) + f(t) b,
///   (q*, dq*)(now) = trajectory(now - t_0),   t_0 = `now` of the first Update after Activate.
/// No inertia or Coriolis torque is fed forward: the arm lags by about (M ddq + friction) / K_P.
/// Gravity is the robot's part. A late or skipped update delays nothing. f b: see SoftStart.
///
/// Integral. Each joint's K_I int (q* - q) dt is kept within +-integral_max, so it neither winds up
/// against an obstacle nor takes long to come back. It is zero at the first update.
///
/// End. After the trajectory the goal at rest is the reference. `finished` is set once all joints
/// are settled (distance and speed in one state), or after settling_time: dry friction may hold a
/// joint off the goal by its break-away torque / K_P, up to 8 mrad at joint 7. It stays set. The
/// robot stops what then still moves. target.joint is the path, for the record.
///
/// Tolerances, as ROS 2's joint_trajectory_controller has them: `failed` is set when, before the
/// path's end, |q* - q| of a joint exceeds its path_tolerance, or when, after settling_time, one is
/// not within its goal_tolerance. It stays set, with the torque of that moment; Explain() has
/// joint, distance and bound. Unlike there, a tolerance that is not given (0) is not looked at in
/// the goal either.
///
/// Threads: all calls from the controller loop's thread. Real-time: Update() is noexcept, O(log
/// points), allocates nothing.
class JointTrajectoryEffortController final : public control::Controller {
 public:
  /// @throws InputError as JointTrajectoryEffortOptions::Validate.
  explicit JointTrajectoryEffortController(reference::Trajectory trajectory,
                                           const JointTrajectoryEffortOptions& options = {});

  [[nodiscard]] control::CommandInterface command_interface() const noexcept override {
    return control::CommandInterface::kTorque;
  }

  /// The options, each by its key. @throws InputError naming place, key, value and range.
  void Configure(control::ParameterReader& parameters) override;

  /// @throws InputError naming the joint, its measured q, the first point and the cure when a joint
  /// is further than start_tolerance_rad from the path's first point (or q is not a number).
  void Activate(const RobotState& state, Time now) override;

  void Update(const RobotState& state, Time now,
              control::ControllerOutput& output) noexcept TWIN_REALTIME override;

  void Deactivate() noexcept override { is_running_ = false; }

  [[nodiscard]] std::string Explain() const override;

  [[nodiscard]] const JointTrajectoryEffortOptions& options() const noexcept { return options_; }

 private:
  /// What a tolerance found.
  struct Breach {
    enum class Of : std::uint8_t { kNothing, kPath, kGoal };
    Of of = Of::kNothing;
    std::size_t joint = 0;
    double distance = 0;  ///< rad
    Duration at{};        ///< since the motion began
  };

  void Begin(Time now) noexcept;
  [[nodiscard]] JointVector Law(const reference::JointTarget& target, const RobotState& state,
                                double dt) noexcept;
  [[nodiscard]] bool IsSettled(const RobotState& state) const noexcept;
  /// Notes the first joint that is further from q* than its tolerance, where it has one.
  void Judge(Breach::Of of, const JointVector& tolerance, const JointVector& q_star,
             const RobotState& state, Duration elapsed) noexcept;

  reference::Trajectory trajectory_;
  JointTrajectoryEffortOptions options_;
  SoftStart soft_start_;
  bool is_running_ = false;  ///< what follows is of the running motion
  bool is_finished_ = false;
  Breach breach_;
  Time start_{};            ///< t_0
  Time last_{};             ///< `now` of the last update
  JointVector integral_{};  ///< K_I int (q* - q) dt, Nm
};

}  // namespace twin::controllers
