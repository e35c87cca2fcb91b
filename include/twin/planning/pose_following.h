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

/// How a path of the end effector is followed, and what is asked of the joints on it.
struct FollowOptions {
  double K_P = 10;      ///< 1/s
  double alpha = 1e-6;  ///< damping, m^2 and rad^2
  Duration step = std::chrono::milliseconds(5);
  double limit_margin = 0.05;   ///< rad, kept from the joint limits
  double velocity_share = 0.5;  ///< of the joints' limits, at most
  /// Likewise. Behind the reference generator a deposit that is used twice beside lost ones makes a
  /// jerk of ddq / T, three times that at worst; at a share of 1/6 it is the limit of every joint.
  double acceleration_share = 0.1;

  /// @throws InputError naming field, value and range.
  void Validate() const;
};

/// Where the joints come to.
struct Followed {
  std::vector<JointVector> q;  ///< rad, a step apart; the last one at rest
  double velocity_load = 0;    ///< largest share of what is asked for: above 1 it is too fast
  double acceleration_load = 0;
};

/// Where the arm goes when its end effector follows a path of poses by damped least squares, as
/// controllers::CartesianPoseController makes it do through the joint position interface:
///   q(t + T) = q(t) + T DLS(J, K_P e + dx_d).
/// What it comes to depends on where it begins; so whoever plans by poses asks this.
///
/// Threads: any. Not for real-time code.
/// @param q  rad, where the arm begins: at the path's first pose. @param F_T_EE  end effector in
/// the flange.
/// @returns where it goes, or why it cannot: a joint would leave its range, or the goal is not
/// reached.
[[nodiscard]] std::variant<Followed, std::string> Follow(const reference::PoseTrajectory& poses,
                                                         const JointVector& q,
                                                         const Transform& F_T_EE,
                                                         const JointLimits& limits,
                                                         const FollowOptions& options = {});

/// The first place of a way through joint space at which something touches, for messages; nothing
/// when it is free. It is looked at so densely that nothing moves by more than twice the clearance
/// between two looks, so nothing touches there either. @param clearance  m, > 0.
[[nodiscard]] std::optional<std::string> FirstTouch(CollisionWorld& world,
                                                    const std::vector<JointVector>& way,
                                                    double clearance);

}  // namespace twin::planning
