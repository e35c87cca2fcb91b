#pragma once

#include <cstdint>

#include "twin/core/joint_interface.h"
#include "twin/core/modes.h"
#include "twin/core/panel.h"
#include "twin/core/realtime.h"
#include "twin/core/request_status.h"
#include "twin/core/rest.h"
#include "twin/core/robot_command.h"
#include "twin/core/robot_state.h"
#include "twin/core/setting.h"
#include "twin/onboard/cartesian_impedance.h"
#include "twin/onboard/friction_compensation.h"
#include "twin/onboard/guiding.h"
#include "twin/onboard/joint_impedance.h"
#include "twin/onboard/loss_monitor.h"
#include "twin/onboard/mode_table.h"
#include "twin/onboard/motion_generator.h"
#include "twin/onboard/onboard_config.h"
#include "twin/onboard/sensing.h"
#include "twin/reference/low_pass.h"
#include "twin/rt/cycle_record.h"

namespace twin::onboard {

/// INT: the robot's own controller, between a command of the workstation and joint torque, 1 ms a
/// cycle. It knows neither the network nor the plant.
///
/// A cycle:
///   1. Cycle(command or null, sensors): what the last sensors showed is judged (Sensing: measured
///      limits, collisions); the command is taken, or acceleration and torque are held
///      (MotionGenerator, CheckTorqueRate), or the motion aborts; then the torque of whoever
///      controls the joints;
///   2. the plant moves by 1 ms;
///   3. FillState(sensors): external torque and contacts are estimated, and the next robot state is
///      written, message_id + 1.
///
/// Motions. Every motion generator (joint position and velocity, Cartesian pose and velocity, with
/// or without elbow) goes with every controller (internal joint impedance, internal Cartesian
/// impedance, external torque). After Move() the next state shows the modes, with the reference at
/// rest; counting of lost commands begins with the first command. 20 lost in a row (configurable)
/// abort with communication_constraints_violation. A command with motion_generation_finished is
/// taken if standing still after it breaks no limit; the motion then ends with Success once the
/// reference rests. The internal controller of the last motion goes on holding the arm.
///
/// External controller. From the first accepted command on, the command's torque drives the joints:
///   tau = tau_J_d + share tau_f(dq) + g(q),   tau_J_d = the last accepted command,
/// and the generator only feeds q_d, dq_d, ddq_d, checked as ever; a plain torque motion is a joint
/// velocity motion with dq_c = 0. Until that command the internal controller holds the arm, and
/// tau_J_d is its torque: a client that continues from the reported tau_J_d is smooth from its
/// first command on. A torque above tau_max is accepted, what is applied ends at tau_max. When the
/// motion ends (finished, StopMove or abort) the arm is where the torque has left it. The internal
/// joint controller takes over there: the reference becomes the measured q and dq with ddq = 0 and
/// ramps down (StopStep); it never leads back to the generator's q_d. A finished command's own
/// torque acts for its cycle; then the arm comes to rest still in Move, and the motion ends with
/// Success.
///
/// Aborts. The violating command is not applied. In the same state: robot_mode Reflex, modes idle,
/// errors and reflex_reason set, success rate 0. The reference ramps down within its limits
/// (StopStep); recovery is refused until it rests, and beyond a joint's measured limit it needs
/// people (kManualErrorRecoveryRequiredRejected): the arm can be guided out of Reflex. StopMove()
/// ramps down still in Move, then ends with Preempted. A collision while Idle leads to Reflex too;
/// reflex_reason, which documents a motion, then stays.
///
/// Halts. When INT cannot go on, with or without a motion, it closes the brakes at once and says
/// instability_detected; mode and errors otherwise as of an abort. It is so when
///   - a sensor gives what is no number, or the torque or the state computed from it is none: no
///     state holds one, in its place is what was measured last;
///   - the arm, held by INT alone (no motion, nobody leads it, brakes open), has not been at rest
///     for kRestTimeout (RestWatch): after each end of a motion it comes to rest, or is braked.
/// The brakes open with the recovery, and while people lead the arm; the reference is then where
/// the arm is. Halts are a decision: by what the robot detects an instability is not public.
///
/// People. The user stop ends a motion with EmergencyAborted, the reference ramps down, then the
/// brakes close until it is released. Closed brakes are mode Other. In Guiding the arm can be led,
/// and the reference follows what is measured. Which request is granted in which mode: kModeTable.
///
/// Setters. Load and end effector change what INT compensates and reports, not what hangs on the
/// arm: a wrong load makes it sag. Their values are checked (FindBadValue).
///
/// Decisions on what is not public: the share of received commands in a motion's first 100 cycles,
/// the 1000 cycles within which a first command must come, precedence of the errors of one cycle
/// (MotionGenerator), recovery taking 100 cycles, how a torque motion ends, that external torque
/// estimated after a cycle is judged in the next one. Source: FCI protocol 5, "Session and motion
/// semantics", "What the robot side does".
///
/// Threads: one thread at a time. Real-time: every member after construction is noexcept and
/// allocates nothing.
class OnboardController {
 public:
  /// @param q0  where the arm rests, rad. @throws InputError as OnboardConfig::Validate.
  OnboardController(const OnboardConfig& config, const JointVector& q0);

  /// Asks for a motion, between two cycles.
  /// @returns kMotionStarted, kCommandNotPossibleRejected (see kModeTable),
  /// kStartAtSingularPoseRejected (Cartesian generators), or kInvalidArgumentRejected (no such
  /// combination of modes).
  [[nodiscard]] MoveStatus Move(const MotionModes& modes) noexcept;

  /// Ends a running motion by deceleration; without one it does nothing. Always a success.
  void StopMove() noexcept;

  /// Leaves Reflex once the reference rests; the mode passes through AutomaticErrorRecovery.
  /// Without an error: success, nothing happens.
  [[nodiscard]] RecoveryStatus AutomaticErrorRecovery() noexcept;

  /// Changes a setting.
  [[nodiscard]] SetterStatus Configure(const Setting& setting) noexcept;

  /// Somebody presses a button or moves a switch. @returns whether the robot does anything of it,
  /// or has no need to (kModeTable).
  [[nodiscard]] bool Operate(PanelAction action) noexcept;

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
  [[nodiscard]] const JointReference& reference() const noexcept { return generator_.joints(); }
  [[nodiscard]] RobotMode robot_mode() const noexcept { return robot_mode_; }
  /// What the last Cycle() found; empty in a cycle without a violation.
  [[nodiscard]] const Violations& violations() const noexcept { return violations_; }
  /// Motions whose first command was accepted, so far: the arm follows from that cycle on.
  [[nodiscard]] std::uint64_t motions_begun() const noexcept { return motions_begun_; }
  /// How the last motion ended (kSuccess, kPreempted, kReflexAborted, kEmergencyAborted), or
  /// kMotionStarted while one runs or before the first.
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

  // onboard_controller.cc: requests and modes
  [[nodiscard]] bool Grants(Request request) const noexcept;
  void Set(const setting::JointImpedance& impedance) noexcept;
  void Set(const setting::CartesianImpedance& impedance) noexcept;
  void Set(const setting::CollisionBehavior& behavior) noexcept;
  void Set(const setting::GuidingMode& mode) noexcept;
  void Set(const setting::StiffnessFrame& frame) noexcept;
  void Set(const setting::EndEffectorFrame& frame) noexcept;
  void Set(const setting::Load& load) noexcept;
  void Set(const setting::Filters& filters) noexcept;
  void ChangeSetup() noexcept;
  /// Ends the motion, if one runs. @param mode  follows in any case.
  void EndMotion(MoveStatus end, RobotMode mode) noexcept;
  void LeaveToRest() noexcept;

  // onboard_cycle.cc: one cycle
  void AdvanceMode(const JointSensors& sensors) noexcept;
  void AdvanceReference(const RobotCommand* command, const JointSensors& sensors) noexcept;
  void AwaitFirstCommand(const RobotCommand* command) noexcept;
  void Take(const RobotCommand& command, bool is_first) noexcept;
  [[nodiscard]] Violations TryStep(const RobotCommand& command, bool is_first,
                                   const Violations& torque) noexcept;
  void Hold() noexcept;
  void Finish(const JointSensors& sensors) noexcept;
  void Abort(const JointSensors& sensors) noexcept;
  void EndByError(RobotMode mode) noexcept;
  void TakeOver(const JointSensors& sensors) noexcept;
  void WatchRest(const JointVector& dq) noexcept;
  void Halt(std::int8_t axis, double value, double limit) noexcept;
  void HaltOnNoNumber() noexcept;
  [[nodiscard]] const JointSensors& Sound(const JointSensors& measured) noexcept;
  void DriveJoints(const JointSensors& sensors) noexcept;
  [[nodiscard]] ImpedanceTorque ControlTorque(const JointSensors& sensors) noexcept;

  // onboard_state.cc: the robot state
  void Fill(const JointSensors& sensors, RobotState& state) noexcept;
  void FillMeasured(const JointSensors& sensors, RobotState& state) noexcept;
  void FillDesired(RobotState& state) const noexcept;
  void FillModes(RobotState& state) const noexcept;

  OnboardConfig config_;
  const model::ArmModel& arm_;
  ArmSetup setup_;
  MotionGenerator generator_;
  Sensing sensing_;
  JointImpedance joint_impedance_;
  CartesianImpedance cartesian_impedance_;
  Guiding guiding_;
  FrictionCompensation friction_;
  reference::LowPass torque_filter_;

  RobotMode robot_mode_ = RobotMode::kIdle;
  Phase phase_ = Phase::kNone;
  MotionModes modes_;
  LossMonitor losses_;
  std::uint64_t motions_begun_ = 0;
  std::uint32_t cycles_waited_ = 0;
  std::uint32_t recovery_cycles_left_ = 0;
  bool brakes_closed_ = false;    ///< by the switch; the user stop closes them for itself
  bool begins_guiding_ = false;   ///< at the next cycle, where the arm then is
  bool payload_changed_ = false;  ///< the observer must start anew
  bool halted_ = false;           ///< the brakes are closed until recovery
  RestWatch rest_;
  JointSensors sound_;  ///< the last measurement that made a state

  rt::CommandFate fate_ = rt::CommandFate::kNone;
  Violations violations_;
  RobotErrors errors_;
  RobotErrors reflex_reason_;
  MoveStatus last_end_ = MoveStatus::kMotionStarted;

  JointDrive drive_;
  JointVector tau_J_d_{};                  ///< of whoever controls the joints, without gravity
  bool external_torque_acts_ = false;      ///< tau_J_d_ is the last accepted command
  bool cartesian_impedance_acts_ = false;  ///< of the internal controllers, the Cartesian one
  JointVector last_tau_J_{};
  std::uint64_t message_id_ = 0;
};

}  // namespace twin::onboard
