#pragma once

#include "twin/core/joint_vector.h"
#include "twin/core/limits.h"
#include "twin/core/realtime.h"
#include "twin/core/robot_state.h"
#include "twin/reference/viability_filter.h"
#include "twin/reference/viable_twist.h"

namespace twin::reference {

/// Viability filter for commanded poses of the end effector, like ViabilityFilter for joints: the
/// last stage before the wire.
///
/// Guarantee: speed, acceleration and jerk of translation and rotation stay within their limits for
/// ever, for any commands, even if up to n consecutive commands are lost (a ViableTwist each).
///
/// Best effort: the limits of the joints. The robot converts poses to joint motions by its own
/// inverse kinematics. The filter predicts the smallest joint step that reaches the pose. If it
/// leaves the set that ViabilityFilter's joints could keep with 0.9 of their limits, the
/// filter sends a milder command: one between slowing down, constant motion and the requested one.
/// This handles what approaches slowly (a joint limit, a singularity) and what is too sudden for a
/// joint. It fails where the pose cannot stop as hard as a joint must, or where the robot moves its
/// elbow differently; the robot's own check then ends the motion.
///
/// An admissible pose passes unchanged, bit by bit.
///
/// Threads: constant after construction. Real-time: noexcept, allocates nothing.
class PoseViabilityFilter {
 public:
  /// @param lost  n. @throws InputError as ViableTwist and ViabilityFilter, naming the motion or
  /// the joint.
  PoseViabilityFilter(const CartesianLimits& cartesian, const JointLimits& joints,
                      int lost = ViabilityFilter::kLostByDefault);

  struct Outcome {
    Transform O_T_EE_c = kIdentityTransform;
    bool active = false;  ///< the command was changed
  };

  /// @param state     the answered one. @param O_T_EE_c  requested pose.
  [[nodiscard]] Outcome Next(const RobotState& state,
                             const Transform& O_T_EE_c) const noexcept TWIN_REALTIME;

  struct TwistOutcome {
    Vector6 O_dP_EE_c{};
    bool active = false;  ///< the command was changed
  };

  /// The same for twists. @param O_dP_EE_c  requested twist, m/s and rad/s, base axes.
  [[nodiscard]] TwistOutcome NextTwist(const RobotState& state,
                                       const Vector6& O_dP_EE_c) const noexcept TWIN_REALTIME;

  /// Margin of the joints: ViabilityFilter::Margin.
  [[nodiscard]] double Margin(const RobotState& state) const noexcept TWIN_REALTIME {
    return joints_.Margin(state.q_d, state.dq_d, state.ddq_d);
  }

 private:
  /// Twist of the end effector, base axes.
  struct Twist {
    Eigen::Vector3d v;
    Eigen::Vector3d w;
  };
  /// A command and the predicted joints.
  struct Option {
    Twist twist;
    JointVector q{};
  };
  struct Step;
  /// The twist to command: the requested one if admissible.
  [[nodiscard]] Twist Kept(const RobotState& state, const Step& from,
                           const Twist& wish) const noexcept;
  [[nodiscard]] static Option Between(const Option& a, const Option& b, double share) noexcept;
  [[nodiscard]] bool Allows(const Step& from, const Twist& twist) const noexcept;
  [[nodiscard]] bool JointsCanKeep(const RobotState& state, const JointVector& q) const noexcept;
  [[nodiscard]] double WorstShare(const RobotState& state, const JointVector& q) const noexcept;
  [[nodiscard]] Twist Milder(const RobotState& state, const Step& from,
                             const Option& wish) const noexcept;
  [[nodiscard]] Twist Towards(const RobotState& state, const Step& from, const Option& base,
                              const Option& wish) const noexcept;

  ViableTwist translation_;
  ViableTwist rotation_;
  ViabilityFilter joints_;
  ViabilityFilter narrow_;  ///< for joints, slightly inside the ends of their ranges
};

}  // namespace twin::reference
