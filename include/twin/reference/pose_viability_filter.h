#pragma once

#include "twin/core/joint_vector.h"
#include "twin/core/limits.h"
#include "twin/core/realtime.h"
#include "twin/core/robot_state.h"
#include "twin/reference/viability_filter.h"
#include "twin/reference/viable_twist.h"

namespace twin::reference {

/// What ViabilityFilter is for joints, for commanded poses of the end effector: stands last before
/// the wire.
///
/// Promised: speed, acceleration and jerk of translation and rotation stay within their limits for
/// ever, whatever is commanded and whatever up to n commands in a row are lost (ViableTwist, one
/// for each).
///
/// Not promised, but aimed at: the limits of the joints. The robot turns poses into joint motions
/// by inverse kinematics of its own. The step of the joints is foreseen as the smallest that
/// reaches the pose; where it leads out of what ViabilityFilter's joints could keep with 0.97 of
/// their limits, a milder command is sent: one between slowing down, going on as before, and the
/// wish. That mends what comes near slowly (a joint limit ahead, a singularity) and what is too
/// sudden for a joint. It cannot where the pose cannot stop as hard as a joint must, or the robot
/// moves its elbow otherwise. Then its own check ends the motion.
///
/// A pose that is admissible passes as it is, bit by bit.
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

  /// @param state     that is answered. @param O_T_EE_c  wished.
  [[nodiscard]] Outcome Next(const RobotState& state,
                             const Transform& O_T_EE_c) const noexcept TWIN_REALTIME;

  struct TwistOutcome {
    Vector6 O_dP_EE_c{};
    bool active = false;  ///< the command was changed
  };

  /// The same on the interface of twists. @param O_dP_EE_c  wished, m/s and rad/s, base axes.
  [[nodiscard]] TwistOutcome NextTwist(const RobotState& state,
                                       const Vector6& O_dP_EE_c) const noexcept TWIN_REALTIME;

  /// Of the joints, as ViabilityFilter::Margin.
  [[nodiscard]] double Margin(const RobotState& state) const noexcept TWIN_REALTIME {
    return joints_.Margin(state.q_d, state.dq_d, state.ddq_d);
  }

 private:
  /// Twist of the end effector, base axes.
  struct Twist {
    Eigen::Vector3d v;
    Eigen::Vector3d w;
  };
  /// A command, and where the joints would be.
  struct Option {
    Twist twist;
    JointVector q{};
  };
  struct Step;
  /// The twist to command: the wished one where it may be.
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
  ViabilityFilter narrow_;  ///< the same, a little shy of the ends of the ranges: on the way there
};

}  // namespace twin::reference
