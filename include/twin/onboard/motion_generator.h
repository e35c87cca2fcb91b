#pragma once

#include <cstdint>
#include <optional>

#include "twin/core/joint_vector.h"
#include "twin/core/limits.h"
#include "twin/core/modes.h"
#include "twin/core/realtime.h"
#include "twin/core/robot_state.h"
#include "twin/core/setting.h"
#include "twin/model/arm_model.h"
#include "twin/onboard/cartesian_reference.h"
#include "twin/onboard/joint_reference.h"
#include "twin/onboard/kinematic_completion.h"
#include "twin/onboard/violations.h"
#include "twin/reference/low_pass.h"

namespace twin::onboard {

/// Limits that the motion generator enforces.
struct GeneratorLimits {
  JointLimits joints;
  CartesianLimits cartesian;
  /// Largest distances between a motion's first command and the reference. Not public; the values
  /// of a simulator of the robot's successor.
  double start_q_rad = 0.1;
  double start_translation_m = 0.05;
  double start_rotation_rad = 0.1;
  double start_elbow_rad = 0.1;
  std::optional<JointLimits> own_joints{};  ///< as OnboardConfig::own_limits
};

/// The reference side of INT: checks commands and forms q_d, dq_d, ddq_d from them.
///
/// Joint generators pass through (q_d = q_c). Cartesian generators use inverse kinematics with the
/// elbow as redundancy (KinematicCompletion); near singularities O_T_EE_d then differs from
/// O_T_EE_c. A step is either applied completely or, with violations, not at all.
///
/// Precedence within a cycle: invalid frame; start pose and start elbow; elbow sign; discontinuity
/// before envelope; Cartesian side before joint side. Only the first violated group is reported.
/// Source: FCI protocol 5, error table and conditions.
///
/// A NaN violates the first check that reads it: in a pose the frame check; in an elbow the check
/// of its start or sign. In later elbows, joint values and twists it violates both discontinuity
/// checks, through the derivatives.
///
/// An elbow counts in cycles whose command has one; the first one after a command without is
/// checked as a start elbow. Without an elbow, elbow_c is that of the joints, and joint 3 is only
/// limited as a joint (after inverse kinematics).
///
/// Threads: INT's. Real-time: all but the constructor; noexcept, allocates nothing.
class MotionGenerator {
 public:
  /// @param q0  initial position, at rest. @pre limits are valid.
  MotionGenerator(const GeneratorLimits& limits, const JointVector& q0);

  /// @param F_T_EE  rigid. @pre no motion runs.
  void SetEndEffector(const Transform& F_T_EE) noexcept;
  /// Sets the low-passes on commanded values. They act before every check except that of the frame,
  /// and their memory is the last commanded value; the elbow uses the filter of the mode's pose or
  /// twist. @pre no motion runs; values in range.
  void SetFilters(const setting::Filters& filters) noexcept;

  /// Whether the arm is singular, so that no Cartesian motion can start.
  [[nodiscard]] bool IsSingular() const noexcept TWIN_REALTIME;

  /// Starts a motion; the reference rests at q_d. @pre at rest; the generator is not kIdle.
  void Start(const MotionModes& modes) noexcept TWIN_REALTIME;

  /// One cycle at rest (before the first command).
  void Rest() noexcept TWIN_REALTIME;

  /// Applies a command if it violates no check.
  /// @param is_first  first of the motion: start pose and start elbow are checked.
  [[nodiscard]] Violations Take(const RobotCommand& command, bool is_first,
                                std::uint64_t message_id) noexcept TWIN_REALTIME;

  /// Without a command: holds the acceleration if that violates no limit; in an asynchronous motion
  /// goes on towards the goal.
  [[nodiscard]] Violations Hold(std::uint64_t message_id) noexcept TWIN_REALTIME;

  /// Checks whether two cycles at the present reference break a limit. Used after Take() for a
  /// command that finishes the motion. In Cartesian motions the commanded pose and the joints stay
  /// constant, and so does a lag behind the pose.
  [[nodiscard]] Violations CheckStandingStill(std::uint64_t message_id) const noexcept
      TWIN_REALTIME;

  /// One unchecked cycle at the present reference, at the end of a motion.
  void StandStill() noexcept TWIN_REALTIME;

  /// One cycle of braking within the joints' limits (StopStep) in any mode; at zero velocity a
  /// cycle at rest. Ends a Cartesian motion.
  void Brake() noexcept TWIN_REALTIME;

  /// Restarts the reference at the measured state of the arm.
  void TakeOver(const JointVector& q, const JointVector& dq) noexcept TWIN_REALTIME;

  [[nodiscard]] const JointReference& joints() const noexcept { return joints_; }
  /// The commanded reference; with a joint generator or none, that of the joints, with zero
  /// accelerations of the pose.
  [[nodiscard]] const CartesianReference& cartesian() const noexcept { return cartesian_; }
  /// Pose and twist of the joint reference. Near singularities they differ from the commanded ones.
  [[nodiscard]] const Transform& O_T_EE_d() const noexcept { return O_T_EE_d_; }
  [[nodiscard]] const Vector6& O_dP_EE_d() const noexcept { return O_dP_EE_d_; }
  [[nodiscard]] bool AtRest() const noexcept;

 private:
  [[nodiscard]] Violations TakeJoints(const RobotCommand& command, bool is_first,
                                      std::uint64_t message_id) noexcept;
  [[nodiscard]] Violations TakeCartesian(const RobotCommand& command, bool is_first,
                                         std::uint64_t message_id) noexcept;
  [[nodiscard]] CartesianReference Commanded(const RobotCommand& command) const noexcept;
  [[nodiscard]] Violations CheckCommand(const RobotCommand& command, const CartesianReference& next,
                                        bool is_first, std::uint64_t message_id) const noexcept;
  [[nodiscard]] Violations TakeGoal(const JointVector& q_c, std::uint64_t message_id) noexcept;
  [[nodiscard]] Violations Approach(std::uint64_t message_id) noexcept;
  [[nodiscard]] Violations CheckStartPosition(const JointVector& q_c,
                                              std::uint64_t message_id) const noexcept;
  [[nodiscard]] Violations AdvanceJoints(const JointReference& next,
                                         std::uint64_t message_id) noexcept;
  [[nodiscard]] Violations AdvanceCartesian(const CartesianReference& next, bool has_elbow,
                                            std::uint64_t message_id) noexcept;
  [[nodiscard]] Violations CheckBothSides(const CartesianReference& cartesian,
                                          const JointReference& joints,
                                          std::uint64_t message_id) const noexcept;
  [[nodiscard]] CartesianReference Still(const CartesianReference& cartesian,
                                         const JointReference& joints) const noexcept;
  void Lead(const JointReference& joints) noexcept;
  [[nodiscard]] const JointLimits& own_limits() const noexcept {
    return limits_.own_joints ? *limits_.own_joints : limits_.joints;
  }

  struct Filters {
    reference::LowPass joint_position;
    reference::LowPass joint_velocity;
    reference::LowPass cartesian_position;
    reference::LowPass cartesian_velocity;
  };
  [[nodiscard]] static Filters Of(const setting::Filters& filters);

  GeneratorLimits limits_;
  Transform F_T_EE_ = kIdentityTransform;
  Filters filters_;
  KinematicCompletion completion_;

  MotionGeneratorMode mode_ = MotionGeneratorMode::kIdle;
  std::optional<JointVector> asynchronous_;  ///< as MotionModes::asynchronous
  JointVector goal_{};                       ///< of an asynchronous motion, rad
  bool has_elbow_ = false;                   ///< in the last command
  KinematicCompletion::Lag lag_{};
  JointReference joints_;
  CartesianReference cartesian_;
  Transform O_T_EE_d_ = kIdentityTransform;
  Vector6 O_dP_EE_d_{};
};

}  // namespace twin::onboard
