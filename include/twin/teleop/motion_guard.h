#pragma once

#include <cstddef>
#include <span>
#include <utility>

#include "twin/core/joint_vector.h"
#include "twin/core/limits.h"
#include "twin/core/mobile_base.h"
#include "twin/core/realtime.h"
#include "twin/core/robot_state.h"
#include "twin/model/arm_model.h"
#include "twin/model/lab_limits.h"
#include "twin/reference/target.h"
#include "twin/teleop/turn_bounds.h"
#include "twin/teleop/twist_bounds.h"

namespace twin::teleop {

/// A fixed body close to the robot.
struct Obstacle {
  double distance = 0;     ///< m; negative when they overlap
  JointVector gradient{};  ///< of the distance by the joints, m/rad
};

/// Finds fixed bodies close to the robot.
class Surroundings {
 public:
  virtual ~Surroundings() = default;
  /// @param q  of the reference. @param base  odometry of a mobile base, from where it began.
  /// @param near  receives the obstacles closer than `horizon`, m.
  /// @returns their number. Called from the controller's thread; must not allocate.
  [[nodiscard]] virtual std::size_t Near(const JointVector& q, const BasePose& base, double horizon,
                                         std::span<Obstacle> near) noexcept TWIN_REALTIME = 0;
};

/// Keeps an operator from leading the arm to where the robot stops itself: ends of joint ranges,
/// fast joints, singular postures, its own links, fixed bodies of the scene.
///
/// Each is a measure h(q) that must stay positive, and bounds the twist u so that h decays no
/// faster than exponentially (a control barrier function),
///   -dh/dq (B u + dq_0) <= g h,   B = J^T (J J^T + d I)^-1,   g = kDecay,
/// dq_0 what the posture does besides following its twist: the hand slows down, stops, and slides
/// along the boundary. Measures: each joint's margin less kJointMargin, of the reference and as
/// measured; the smallest singular value of J less kLeastSingular; model::SelfDistance less
/// kSelfMargin; the distance from each fixed body less kSceneMargin; of a lab's limits, the margin
/// of each region less kRegionMargin, and what is left to the caps on force and torque over the
/// stiffnesses kStiffest and kStiffestJoint, from half of a cap on. Caps on the joints' speed bound
/// the falling of the joints' margins. A negative measure leads the arm back, slowly. All are
/// evaluated at the reference's posture, kAhead later along its motion, q_r + dq_r kAhead: the
/// shaped reference follows the twist with a delay.
///
/// A joint j that turns alone at s has the same measures: -dh/dq_j s <= max(g h, 0).
///
/// Source: Ames et al., "Control Barrier Functions: Theory and Applications", ECC 2019. The
/// constants are decisions.
///
/// Threads: one. Real-time: noexcept, does not allocate.
class MotionGuard {
 public:
  static constexpr double kDecay = 3;              ///< g, 1/s
  static constexpr double kAhead = 0.05;           ///< s
  static constexpr double kJointMargin = 0.08;     ///< rad
  static constexpr double kJointSpeedShare = 0.5;  ///< of a joint's largest speed
  static constexpr double kLeastSingular = 0.1;    ///< m
  static constexpr double kSelfMargin = 0.05;      ///< m; INT stops the arm at 0.01
  static constexpr double kSceneMargin = 0.02;     ///< m
  static constexpr double kRegionMargin = 0.02;    ///< m
  static constexpr double kCapShare = 0.9;         ///< of a lab's cap on speed
  static constexpr double kStiffest = 3000;        ///< N/m, of the led arm and what it touches
  static constexpr double kStiffestJoint = 2000;   ///< Nm/rad
  static constexpr double kHorizon = 0.12;  ///< m; farther bodies do not bound the fastest hand
  static constexpr std::size_t kMostObstacles = 16;
  static constexpr std::size_t kMostPlanes = 16;  ///< of regions

  /// @param arm  and surroundings (null for none) must outlive the guard.
  MotionGuard(const model::ArmModel& arm, const JointLimits& limits, bool with_hand,
              Surroundings* surroundings, model::LabLimits lab = {})
      : arm_(arm),
        limits_(limits),
        with_hand_(with_hand),
        surroundings_(surroundings),
        lab_(std::move(lab)) {}

  /// Adds the bounds of the end effector's twist (base axes, m/s and rad/s).
  /// @param posture  q_r and dq_r. @param twist  that it follows. @param base  odometry of a mobile
  /// base, from where it began.
  void AddTo(TwistBounds& bounds, const reference::JointTarget& posture, const Vector6& twist,
             const RobotState& state, const BasePose& base = {}) noexcept TWIN_REALTIME;

  /// Adds the bounds of the speed of one joint that turns alone, rad/s.
  /// @param joint  from 0. @param posture, base  as above.
  void AddTo(TurnBounds& bounds, std::size_t joint, const reference::JointTarget& posture,
             const RobotState& state, const BasePose& base = {}) noexcept TWIN_REALTIME;

 private:
  /// Calls keep(h, dh/dq, bound, largest speed of h) for each measure at q. @param J  there.
  template <typename Keep>
  void Measure(const JointVector& q, const model::Jacobian& J, const RobotState& state,
               const BasePose& base, const Keep& keep) noexcept;

  const model::ArmModel& arm_;
  const JointLimits limits_;
  const bool with_hand_;
  Surroundings* const surroundings_;
  const model::LabLimits lab_;
};

}  // namespace twin::teleop
