#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "twin/core/joint_vector.h"
#include "twin/core/limits.h"
#include "twin/core/time.h"
#include "twin/planning/collision_world.h"
#include "twin/reference/pose_trajectory.h"

namespace twin::planning {

/// Parameters for following an end-effector path, and bounds on the joints.
struct FollowOptions {
  double K_P = 10;      ///< 1/s
  double alpha = 1e-6;  ///< damping, m^2 and rad^2
  Duration step = std::chrono::milliseconds(5);
  double limit_margin = 0.05;   ///< rad, distance from the joint limits
  double velocity_share = 0.5;  ///< of the joints' limits
  /// Largest share of the joints' limits. Behind the reference generator, a deposit used twice next
  /// to lost ones causes a jerk of ddq / T, at worst three times that; at a share of 1/6 this is
  /// every joint's limit.
  double acceleration_share = 0.1;

  /// @throws InputError naming field, value and range.
  void Validate() const;
};

/// Resulting motion of the joints.
struct Followed {
  std::vector<JointVector> q;  ///< rad, one per step; the last one at rest
  double velocity_load = 0;    ///< largest share of the bound; above 1: too fast
  double acceleration_load = 0;
};

/// Simulates an arm whose end effector follows a path of poses by damped least squares, as
/// controllers::CartesianPoseController does through the joint position interface:
///   q(t + T) = q(t) + T DLS(J, K_P e + dx_d).
/// The result depends on the start, so planning by poses requires it.
///
/// Threads: any. Not for real-time code.
/// @param q  initial joints, rad: at the path's first pose. @param F_T_EE  end effector in the
/// flange.
/// @returns the motion, or the failure: a joint would leave its range, or the goal is not reached.
[[nodiscard]] std::variant<Followed, std::string> Follow(const reference::PoseTrajectory& poses,
                                                         const JointVector& q,
                                                         const Transform& F_T_EE,
                                                         const JointLimits& limits,
                                                         const FollowOptions& options = {});

/// @returns the first contact along a joint-space path, for messages; nullopt if the path is free.
/// Between two checks nothing moves by more than twice the clearance, so nothing touches there
/// either.
/// @param clearance  m, > 0.
[[nodiscard]] std::optional<std::string> FirstTouch(CollisionWorld& world,
                                                    const std::vector<JointVector>& way,
                                                    double clearance);

}  // namespace twin::planning
