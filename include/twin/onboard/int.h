#pragma once

#include <cstdint>

#include "twin/core/joint_interface.h"
#include "twin/core/modes.h"
#include "twin/core/realtime.h"
#include "twin/core/robot_command.h"
#include "twin/core/robot_state.h"
#include "twin/onboard/friction_compensation.h"
#include "twin/onboard/int_config.h"
#include "twin/onboard/joint_impedance.h"
#include "twin/onboard/joint_reference.h"
#include "twin/onboard/limit_monitor.h"
#include "twin/onboard/loss_monitor.h"
#include "twin/rt/cycle_record.h"

namespace twin::onboard {

/// Answers to a Move request; values are those of the wire. Source: FCI protocol 5, status values.
enum class MoveStatus : std::uint8_t {
  kSuccess = 0,
  kMotionStarted = 1,
  kPreempted = 2,
  kCommandNotPossibleRejected = 3,
  kStartAtSingularPoseRejected = 4,
  kInvalidArgumentRejected = 5,
  kReflexAborted = 6,
  kEmergencyAborted = 7,
  kInputErrorAborted = 8,
  kAborted = 9,
};

/// Answers to a setter; values are those of the wire.
enum class SetterStatus : std::uint8_t {
  kSuccess = 0,
  kCommandNotPossibleRejected = 1,
  kInvalidArgumentRejected = 2,
};

/// Answers to automatic error recovery; values are those of the wire.
enum class RecoveryStatus : std::uint8_t {
  kSuccess = 0,
  kCommandNotPossibleRejected = 1,
};

/// INT: the robot's own controller, between a command of the workstation and joint torque, 1 ms a
/// cycle. It knows neither the network nor the plant.
///
/// A cycle:
///   1. Cycle(command or null, sensors): with a motion running, check the measured torque
///      (CheckTorqueRange); take the command or hold the last acceleration and torque; form the
///      derivatives (JointReference); check them (CheckStep, CheckTorqueRate); accept or abort;
///      then the torque of whoever controls the joints.
///   2. the plant moves by 1 ms;
///   3. FillState(sensors): the next robot state, message_id + 1.
///
/// Motions. Modes here: joint position and joint velocity, each with the internal joint impedance
/// or the external controller. After Move() the next state shows the modes, with the reference at
/// rest; counting of lost commands begins with the first command. 20 lost in a row (configurable)
/// abort with communication_constraints_violation. A command with motion_generation_finished is
/// taken if standing still after it breaks no limit; the motion then ends with Success once the
/// reference rests.
///
/// External controller. From the first accepted command on, the command's torque drives the joints:
///   tau = tau_J_d + share tau_f(dq) + g(q),   tau_J_d = the last accepted command,
/// and the generator only feeds q_d, dq_d, ddq_d, checked as ever; a plain torque motion is a joint
/// velocity motion with dq_c = 0. Until that command the internal controller holds the arm, and
/// tau_J_d is its torque: a client that continues from the reported tau_J_d is smooth from its
/// first command on. A torque above tau_max is accepted, what is applied ends at tau_max. When the
/// motion ends (finished, StopMove or abort) the arm is where the torque has left it. The internal
/// controller takes over there (TakeOver): the reference becomes the measured q and dq with ddq = 0
/// and ramps down (StopStep); it never leads back to the generator's q_d. A finished command's own
/// torque acts for its cycle; then the arm comes to rest still in Move, and the motion ends with
/// Success.
///
/// Aborts. The violating command is not applied. In the same state: robot_mode Reflex, modes idle,
/// errors and reflex_reason set, success rate 0. The reference ramps down within its limits
/// (StopStep); recovery is refused until it rests. StopMove() ramps down still in Move, then ends
/// with Preempted.
///
/// Decisions on what is not public: the share of received commands in a motion's first 100 cycles,
/// the 1000 cycles within which a first command must come, errors of one cycle (LimitMonitor's
/// precedence), recovery taking 100 cycles, how a torque motion ends, and the range of the measured
/// torque (IntConfig::tau_J_range). Source: FCI protocol 5, "Session and motion semantics",
/// "What the robot side does".
///
/// Threads: one thread at a time. Real-time: every member after construction is noexcept and
/// allocates nothing.
class Int {
 public:
  /// @param q0  where the arm rests, rad. @throws InputError as IntConfig::Validate.
  Int(const IntConfig& config, const JointVector& q0);

  /// Asks for a motion, between two cycles.
  /// @returns kMotionStarted, kCommandNotPossibleRejected (not Idle, or the reference still moves),
  /// or kInvalidArgumentRejected (a combination of modes this robot does not offer).
  [[nodiscard]] MoveStatus Move(const MotionModes& modes) noexcept;

  /// Ends a running motion by deceleration; without one it does nothing. Always a success.
  void StopMove() noexcept;

  /// Leaves Reflex once the reference rests; the mode passes through AutomaticErrorRecovery.
  /// Without an error: success, nothing happens.
  [[nodiscard]] RecoveryStatus AutomaticErrorRecovery() noexcept;

  /// @param K_theta  Nm/rad, each in [0, 14250]. Refused while moving or in Reflex.
  [[nodiscard]] SetterStatus SetJointImpedance(const JointVector& K_theta) noexcept;

  /// One cycle. @param command  the one that counts for this cycle (CommandInbox), or null.
  /// @param sensors  of the last state. @returns what drives the joints, valid until the next call.
  const JointDrive& Cycle(const RobotCommand* command,
                          const JointSensors& sensors) noexcept TWIN_REALTIME;

  /// Writes the state this cycle sends. @param sensors  after the plant's step.
  void FillState(const JointSensors& sensors, RobotState& state) noexcept TWIN_REALTIME;

  /// Id of the last state filled; 0 before the first.
  [[nodiscard]] std::uint64_t message_id() const noexcept { return message_id_; }
  /// What the last Cycle() did about its command.
  [[nodiscard]] rt::CommandFate fate() const noexcept { return fate_; }
  [[nodiscard]] std::uint32_t lost_in_row() const noexcept { return losses_.lost_in_row(); }
  [[nodiscard]] const JointReference& reference() const noexcept { return reference_; }
  [[nodiscard]] RobotMode robot_mode() const noexcept { return robot_mode_; }
  /// What the last Cycle() found; empty in a cycle without a violation.
  [[nodiscard]] const Violations& violations() const noexcept { return violations_; }
  /// How the last motion ended (kSuccess, kPreempted, kReflexAborted), or kMotionStarted while one
  /// runs or before the first.
  [[nodiscard]] MoveStatus last_end() const noexcept { return last_end_; }

 private:
  /// What a running motion is doing.
  enum class Phase : std::uint8_t {
    kNone,        ///< no motion
    kStarting,    ///< no command yet
    kRunning,     ///< commands are taken or held
    kFinishing,   ///< finished command taken: the reference comes to rest
    kPreempting,  ///< StopMove: the reference decelerates
  };

  void AdvanceReference(const RobotCommand* command, const JointSensors& sensors) noexcept;
  void AwaitFirstCommand(const RobotCommand* command) noexcept;
  void Take(const RobotCommand& command) noexcept;
  void Hold() noexcept;
  [[nodiscard]] JointReference Commanded(const RobotCommand& command) const noexcept;
  [[nodiscard]] Violations CheckStandingStill(const JointReference& last) const noexcept;
  void Finish(const JointSensors& sensors) noexcept;
  void Abort(const JointSensors& sensors) noexcept;
  void EndMotion(MoveStatus end) noexcept;
  void TakeOver(const JointSensors& sensors) noexcept;
  void DriveJoints(const JointSensors& sensors) noexcept;
  void FillDesired(RobotState& state) const noexcept;

  IntConfig config_;
  const model::ArmModel& arm_;
  JointImpedance impedance_;
  FrictionCompensation friction_;
  JointVector tau_J_range_;
  Transform F_T_EE_;

  RobotMode robot_mode_ = RobotMode::kIdle;
  Phase phase_ = Phase::kNone;
  MotionModes modes_;
  JointReference reference_;
  LossMonitor losses_;
  std::uint32_t cycles_waited_ = 0;
  std::uint32_t recovery_cycles_left_ = 0;

  rt::CommandFate fate_ = rt::CommandFate::kNone;
  Violations violations_;
  RobotErrors errors_;
  RobotErrors reflex_reason_;
  MoveStatus last_end_ = MoveStatus::kMotionStarted;

  JointDrive drive_;
  JointVector tau_J_d_{};              ///< of whoever controls the joints, without gravity
  bool external_torque_acts_ = false;  ///< tau_J_d_ is the last accepted command
  JointVector last_tau_J_{};
  std::uint64_t message_id_ = 0;
};

}  // namespace twin::onboard
