#pragma once

#include <cstdint>

#include "twin/core/joint_vector.h"
#include "twin/core/limits.h"
#include "twin/core/modes.h"
#include "twin/core/realtime.h"
#include "twin/core/robot_command.h"
#include "twin/core/setting.h"
#include "twin/model/arm_model.h"
#include "twin/onboard/cartesian_reference.h"
#include "twin/onboard/joint_reference.h"
#include "twin/onboard/kinematic_completion.h"
#include "twin/onboard/violations.h"
#include "twin/reference/low_pass.h"

namespace twin::onboard {

/// What the motion generator checks against.
struct GeneratorLimits {
  JointLimits joints;
  CartesianLimits cartesian;
  /// Largest distances of a motion's first command from the reference; not public, what a simulator
  /// of the successor uses.
  double start_q_rad = 0.1;
  double start_translation_m = 0.05;
  double start_rotation_rad = 0.1;
  double start_elbow_rad = 0.1;
};

/// The reference side of INT: from commands to q_d, dq_d, ddq_d, through every check of a command.
///
/// Joint generators pass through (q_d = q_c). Cartesian ones go through inverse kinematics with the
/// elbow as redundancy (KinematicCompletion); near singularities O_T_EE_d then differs from
/// O_T_EE_c. A step is either taken as a whole or, with violations, not at all.
///
/// Precedence within a cycle: what is no pose at all (invalid frame), start pose and elbow, elbow
/// sign; discontinuity before envelope; Cartesian side before joint side. Only the first group that
/// is violated is reported. Source: FCI protocol 5, error table and conditions.
///
/// What is no number breaks the first check that looks at it: in a pose the frame's; in an elbow
/// that of its start or sign, later, like in joint values and twists, both discontinuities (it
/// makes derivatives that are no numbers).
///
/// An elbow counts in the cycles whose command has one. The first after a command without is
/// checked as a start elbow. Without one, elbow_c is what the joints have, and a limit of joint 3
/// is that of a joint (after inverse kinematics).
///
/// Threads: INT's. Real-time: all but the constructor; noexcept, allocates nothing.
class MotionGenerator {
 public:
  /// @param q0  where the arm rests. @pre limits are valid.
  MotionGenerator(const GeneratorLimits& limits, const JointVector& q0);

  /// @param F_T_EE  rigid. @pre no motion runs.
  void SetEndEffector(const Transform& F_T_EE) noexcept;
  /// Low-passes on commanded values, before every check, with the last commanded value as their
  /// memory; the elbow's is that of the mode's pose or twist. What a pose must be at all (frame) is
  /// checked before. @pre no motion runs; values in range.
  void SetFilters(const setting::Filters& filters) noexcept;

  /// Whether a Cartesian motion could not start here: the arm is singular.
  [[nodiscard]] bool IsSingular() const noexcept TWIN_REALTIME;

  /// A motion begins: the reference rests at q_d. @pre at rest; mode is not kIdle.
  void Start(MotionGeneratorMode mode) noexcept TWIN_REALTIME;

  /// Keeps the reference at rest for a cycle (before the first command).
  void Rest() noexcept TWIN_REALTIME;

  /// Takes a command, if nothing is wrong with it.
  /// @param is_first  of the motion: start pose and start elbow are checked.
  [[nodiscard]] Violations Take(const RobotCommand& command, bool is_first,
                                std::uint64_t message_id) noexcept TWIN_REALTIME;

  /// No command came: holds the acceleration, if that stays within the limits.
  [[nodiscard]] Violations Hold(std::uint64_t message_id) noexcept TWIN_REALTIME;

  /// Would two cycles at the reference as it stands break a limit? What a command that finishes the
  /// motion is checked for, after Take(). Cartesian motions: the commanded pose and the joints
  /// stand still, a lag behind the pose is left as it is.
  [[nodiscard]] Violations CheckStandingStill(std::uint64_t message_id) const noexcept
      TWIN_REALTIME;

  /// One cycle at the reference as it stands, unchecked: the end of a motion that may finish.
  void StandStill() noexcept TWIN_REALTIME;

  /// One cycle of coming to rest within the joints' limits (StopStep), whatever mode ran; without
  /// velocity it is a cycle at rest. A Cartesian motion is over with it.
  void Brake() noexcept TWIN_REALTIME;

  /// The reference leaves what it was and starts from where the arm is.
  void TakeOver(const JointVector& q, const JointVector& dq) noexcept TWIN_REALTIME;

  [[nodiscard]] const JointReference& joints() const noexcept { return joints_; }
  /// What was commanded, or, with a joint generator or none, what the joints' reference amounts to;
  /// accelerations of the pose are then zero.
  [[nodiscard]] const CartesianReference& cartesian() const noexcept { return cartesian_; }
  /// Pose and twist of the joints' reference. They differ from the commanded ones near
  /// singularities.
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
  bool has_elbow_ = false;  ///< the last command had one
  KinematicCompletion::Lag lag_{};
  JointReference joints_;
  CartesianReference cartesian_;
  Transform O_T_EE_d_ = kIdentityTransform;
  Vector6 O_dP_EE_d_{};
};

}  // namespace twin::onboard
