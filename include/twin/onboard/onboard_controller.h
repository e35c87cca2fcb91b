#pragma once

#include <cstdint>
#include <optional>

#include "twin/core/body_interface.h"
#include "twin/core/modes.h"
#include "twin/core/realtime.h"
#include "twin/core/request_status.h"
#include "twin/core/rest.h"
#include "twin/core/robot_state.h"
#include "twin/core/setting.h"
#include "twin/onboard/accelerometers.h"
#include "twin/onboard/cartesian_impedance.h"
#include "twin/onboard/friction_compensation.h"
#include "twin/onboard/guiding.h"
#include "twin/onboard/joint_impedance.h"
#include "twin/onboard/loss_monitor.h"
#include "twin/onboard/mode_table.h"
#include "twin/onboard/motion_generator.h"
#include "twin/onboard/onboard_config.h"
#include "twin/onboard/sensing.h"
#include "twin/onboard/stop_proof.h"
#include "twin/record/cycle_record.h"
#include "twin/reference/low_pass.h"

namespace twin::onboard {

/// INT: the robot's controller, from a workstation's command to joint torque, in cycles of 1 ms. It
/// depends on neither the network nor the plant.
///
/// A cycle:
///   1. Cycle(command or null, sensors) checks the last sensor values (Sensing: measured limits,
///      collisions); applies the command, or holds acceleration and torque (MotionGenerator,
///      CheckTorqueRate), or aborts the motion; then computes the torque of the active controller;
///   2. the plant advances by 1 ms;
///   3. FillState(sensors) estimates external torque and contacts and writes the next robot state,
///      message_id + 1.
///
/// Motions. Every motion generator (joint position and velocity, Cartesian pose and velocity, with
/// or without elbow) works with every controller (internal joint impedance, internal Cartesian
/// impedance, external torque). After Move() the next state shows the modes, with the reference at
/// rest; counting of lost commands starts with the first command. 20 consecutive losses
/// (configurable) abort with communication_constraints_violation. motion_generation_finished is
/// accepted if standing still then breaks no limit; the motion ends with Success once the reference
/// rests. The internal controller of the motion then holds the arm.
///
/// External controller. From the first accepted command on, the commanded torque drives the joints:
///   tau = tau_J_d + share tau_f(dq) + g(q),   tau_J_d = the last accepted command.
/// The generator then only forms and checks q_d, dq_d, ddq_d; a pure torque motion is a joint
/// velocity motion with dq_c = 0, or one without a generator (kNone), in which q_d stands still.
/// Before that command the internal controller holds the arm and tau_J_d is its torque, so a client
/// that continues from the reported tau_J_d starts smoothly. A torque above tau_max is accepted and
/// applied cut to tau_max. When the motion ends (finished, StopMove or abort) the internal joint
/// controller takes over: the reference restarts at the measured q and dq with ddq = 0 and ramps
/// down (StopStep); it never returns to the generator's q_d. The torque of a finishing command acts
/// for its cycle; the arm then comes to rest still in Move, and the motion ends with Success.
///
/// Asynchronous motions (MotionModes::asynchronous). A command is a goal; ApproachStep() forms the
/// reference. Commands come at any time, so that none counts as lost and the first one has no
/// deadline. A goal outside a joint's range is refused as a position beyond its limit. A finishing
/// command has no goal: INT brakes, then ends the motion with Success.
///
/// Aborts. The violating command is not applied. The same state shows robot_mode Reflex, modes
/// idle, errors and reflex_reason, and success rate 0. The reference ramps down within its limits
/// (StopStep); recovery is refused until it rests. Beyond a joint's measured limit, recovery needs
/// people (kManualErrorRecoveryRequiredRejected), who can guide the arm out of Reflex. StopMove()
/// ramps down still in Move, then ends with Preempted; a ramp that takes q_d beyond a joint's range
/// aborts with the generator's error of joint positions, unless a torque drove the arm. A collision
/// in Idle also leads to Reflex, but keeps reflex_reason, which documents a motion.
///
/// Halts. When INT cannot continue, with or without a motion, it closes the brakes at once and
/// raises instability_detected; otherwise mode and errors are those of an abort. It halts when
///   - a sensor value, or a torque or state computed from it, is not finite; the state then repeats
///     the last valid measurement;
///   - the arm, held by INT alone (no motion, no guiding, brakes open), has not come to rest for
///     kRestTimeout (RestWatch), e.g. after a motion.
/// Recovery and guiding open the brakes; the reference then restarts at the arm's position. Halts
/// are a decision: how the robot detects an instability is not public.
///
/// People. The user stop ends a motion with EmergencyAborted; the reference ramps down, then the
/// brakes stay closed until release. Closed brakes mean mode Other. In Guiding people lead the arm
/// and the reference follows the measurement. kModeTable lists which mode grants which request.
///
/// Guard. With limits of a lab (OnboardConfig::guard), INT also aborts before a cycle after which
/// the stop that an abort executes would break one (StopProof); that of the cycle before is proved.
/// A held acceleration is checked like a command, so the guarantee includes lost commands. Under
/// external torques the stop begins at the measured q and dq, which the check predicts by one
/// cycle: torques may accelerate the arm more, so this is no proof. Measured forces are checked in
/// motions.
///
/// | limit | error | axis |
/// |---|---|---|
/// | region | cartesian_position_limits_violation | index of the region |
/// | speed of a joint | joint_velocity_violation | joint |
/// | speed or turn of the end effector | cartesian_velocity_violation | 0 or 1 |
/// | external force or torque | force_control_safety_violation | none |
///
/// The errors are a decision: clients know no others. guard_breach() has the limit itself.
///
/// Setters. Load and end effector change what INT compensates and reports, not the plant: a wrong
/// load makes the arm sag. FindBadValue checks their values.
///
/// Decisions on what is not public: the success rate in a motion's first 100 cycles, the 1000
/// cycles within which a first command must arrive, the precedence of errors in one cycle
/// (MotionGenerator), recovery taking 100 cycles, the end of a torque motion, a ramp beyond a
/// range, and that external torque estimated after a cycle is checked in the next one. Source: FCI
/// protocol 5, "Session and motion semantics", "What the robot side does".
///
/// Threads: one thread at a time. Real-time: every member after construction is noexcept and
/// allocates nothing.
class OnboardController {
 public:
  /// @param q0  initial position, at rest, rad. @throws InputError as OnboardConfig::Validate.
  OnboardController(const OnboardConfig& config, const JointVector& q0);
  OnboardController(const OnboardController&) = default;
  /// The whole controller, with its message ids.
  OnboardController& operator=(const OnboardController& other) noexcept;

  /// As constructed anew with the arm at q0, between two cycles: settings, modes and errors are the
  /// configured ones again. Only message ids and motions_begun() go on.
  /// @param config  valid. Not for real time.
  void Restart(const OnboardConfig& config, const JointVector& q0);

  /// Requests a motion, between two cycles.
  /// @returns kMotionStarted, kCommandNotPossibleRejected (see kModeTable),
  /// kStartAtSingularPoseRejected (Cartesian generators), or kInvalidArgumentRejected (no such
  /// combination of modes).
  [[nodiscard]] MoveStatus Move(const MotionModes& modes) noexcept;

  /// Ends a running motion by deceleration; has no effect without one. Always succeeds.
  void StopMove() noexcept;

  /// Leaves Reflex once the reference rests; the mode passes through AutomaticErrorRecovery.
  /// Succeeds without effect if there is no error.
  [[nodiscard]] RecoveryStatus AutomaticErrorRecovery() noexcept;

  /// Applies a setter.
  [[nodiscard]] SetterStatus Configure(const Setting& setting) noexcept;

  /// Presses a button or moves a switch. @returns whether the robot accepts it, with or without
  /// effect (kModeTable).
  [[nodiscard]] bool Operate(PanelAction action) noexcept;

  /// Runs one cycle. @param command  the one that counts for this cycle (CommandInbox), or null.
  /// @param sensors  of the last state. @returns drive of the joints, valid until the next call.
  const JointDrive& Cycle(const RobotCommand* command,
                          const JointSensors& sensors) noexcept TWIN_REALTIME;

  /// Writes the state that this cycle sends. @param sensors  after the plant's step.
  void FillState(const JointSensors& sensors, RobotState& state) noexcept TWIN_REALTIME;

  /// Id of the last state filled; 0 before the first.
  [[nodiscard]] std::uint64_t message_id() const noexcept { return message_id_; }
  /// An asynchronous motion is under way.
  [[nodiscard]] bool is_asynchronous() const noexcept {
    return phase_ != Phase::kNone && modes_.asynchronous;
  }
  /// Id of the oldest state that a command may answer: the last one's; in an asynchronous motion
  /// the first one's of the motion.
  [[nodiscard]] std::uint64_t oldest_answered() const noexcept {
    return is_asynchronous() ? motion_id_ : message_id_;
  }
  /// Fate of the command of the last Cycle().
  [[nodiscard]] record::CommandFate fate() const noexcept { return fate_; }
  [[nodiscard]] std::uint32_t lost_in_row() const noexcept { return losses_.lost_in_row(); }
  [[nodiscard]] const JointReference& reference() const noexcept { return generator_.joints(); }
  [[nodiscard]] RobotMode robot_mode() const noexcept { return robot_mode_; }
  /// Violations of the last Cycle(); empty without one.
  [[nodiscard]] const Violations& violations() const noexcept { return violations_; }
  /// The limit of the guard that ended the last motion; nullopt: none.
  [[nodiscard]] const std::optional<BrokenLimit>& guard_breach() const noexcept {
    return guard_breach_;
  }
  /// Number of motions whose first command was accepted; the arm follows from that cycle on.
  [[nodiscard]] std::uint64_t motions_begun() const noexcept { return motions_begun_; }
  /// How the last motion ended (kSuccess, kPreempted, kReflexAborted, kEmergencyAborted), or
  /// kMotionStarted while one runs or before the first.
  [[nodiscard]] MoveStatus last_end() const noexcept { return last_end_; }

 private:
  /// Phase of a running motion.
  enum class Phase : std::uint8_t {
    kNone,        ///< no motion
    kStarting,    ///< no command yet
    kRunning,     ///< applies or holds commands
    kFinishing,   ///< finishing command accepted: the reference comes to rest
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
  /// Ends a running motion. @param mode  next mode, also without a motion.
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
  void Preempt(const JointSensors& sensors) noexcept;
  void Abort(const JointSensors& sensors) noexcept;
  void EndByError(RobotMode mode) noexcept;
  void TakeOver(const JointSensors& sensors) noexcept;
  void WatchRest(const JointVector& dq) noexcept;
  void Halt(std::int8_t axis, double value, double limit) noexcept;
  void HaltOnNoNumber() noexcept;
  [[nodiscard]] const JointSensors& Sound(const JointSensors& measured) noexcept;
  void DriveJoints(const JointSensors& sensors) noexcept;
  [[nodiscard]] ImpedanceTorque ControlTorque(const JointSensors& sensors) noexcept;

  // onboard_guard.cc: limits of a lab
  [[nodiscard]] Violations Guarded(const std::optional<BrokenLimit>& breach) noexcept;
  [[nodiscard]] Violations CheckStopOf(const MotionGenerator& next) noexcept;
  [[nodiscard]] Violations CheckGuardMeasured(const JointSensors& sensors) noexcept;
  [[nodiscard]] Violations HoldGuarded() noexcept;

  // onboard_state.cc: the robot state
  void Fill(const JointSensors& sensors, RobotState& state) noexcept;
  void FillMeasured(const JointSensors& sensors, RobotState& state) noexcept;
  void FillDesired(RobotState& state) const noexcept;
  void FillModes(RobotState& state) const noexcept;

  OnboardConfig config_;
  ArmSetup setup_;
  MotionGenerator generator_;
  Sensing sensing_;
  JointImpedance joint_impedance_;
  CartesianImpedance cartesian_impedance_;
  Guiding guiding_;
  FrictionCompensation friction_;
  Accelerometers accelerometers_;
  reference::LowPass torque_filter_;

  RobotMode robot_mode_ = RobotMode::kIdle;
  Phase phase_ = Phase::kNone;
  MotionModes modes_;
  LossMonitor losses_;
  std::uint64_t motions_begun_ = 0;
  std::uint64_t motion_id_ = 0;  ///< of the first state of the last motion
  std::uint32_t cycles_waited_ = 0;
  std::uint32_t recovery_cycles_left_ = 0;
  bool brakes_closed_ = false;    ///< by the switch; the user stop closes them independently
  bool begins_guiding_ = false;   ///< at the next cycle, at the arm's position then
  bool payload_changed_ = false;  ///< the observer must restart
  bool halted_ = false;           ///< the brakes are closed until recovery
  RestWatch rest_;
  JointSensors sound_;  ///< the last measurement that gave a valid state

  std::optional<StopProof> guard_;  ///< absent without limits of a lab
  std::optional<BrokenLimit> guard_breach_;

  record::CommandFate fate_ = record::CommandFate::kNone;
  Violations violations_;
  RobotErrors errors_;
  RobotErrors reflex_reason_;
  MoveStatus last_end_ = MoveStatus::kMotionStarted;

  JointDrive drive_;
  JointVector tau_J_d_{};                  ///< of the active controller, without gravity
  bool external_torque_acts_ = false;      ///< tau_J_d_ is the last accepted command
  bool cartesian_impedance_acts_ = false;  ///< the internal controller is the Cartesian one
  JointVector last_tau_J_{};
  std::uint64_t message_id_ = 0;
  bool is_new_ = true;  ///< no state was filled since construction or Restart()
};

}  // namespace twin::onboard
