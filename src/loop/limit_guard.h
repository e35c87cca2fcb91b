#pragma once

#include <optional>

#include "twin/control/controller.h"
#include "twin/core/realtime.h"
#include "twin/core/robot_state.h"
#include "twin/loop/loop_config.h"
#include "twin/onboard/kinematic_completion.h"
#include "twin/onboard/stop_proof.h"

namespace twin::loop {

/// The last stage of the command chain when a lab limits the motion: it lets a command pass only if
/// the arm can still stop within the limits after it (onboard::StopProof). Otherwise it begins the
/// stop that it proved with the command before, and keeps to it.
///
/// | interface | reference after the command | the stop |
/// |---|---|---|
/// | joint positions, velocities | INT's law, exact | commanded, StopStep in every cycle |
/// | poses | this project's inverse kinematics | the robot's, asked for at once |
/// | torques | the measured q and dq, one cycle on | the robot's, asked for at once |
///
/// Until the robot's own stop acts, the robot holds the acceleration.
///
/// So only a stream of joint positions or velocities is proved, and only if no command is lost
/// right before the stop and during it. For poses the proof is also made for accelerations held for
/// kHeldCycles; the robot's inverse kinematics is an assumption. For torques it is a prediction.
///
/// Measured forces and torques above their caps begin the same stop.
///
/// Threads: one. Real-time: all but the constructor; noexcept, allocates nothing.
class LimitGuard {
 public:
  /// Cycles that the robot may hold its acceleration before it acts on a request to stop.
  static constexpr int kHeldCycles = 5;

  /// @pre config.lab.
  LimitGuard(const TickConfig& config, control::CommandInterface interface);

  /// Starts a motion with the end effector of this state.
  void Reset(const RobotState& state) noexcept TWIN_REALTIME;

  /// Passes the command that answers `state`, or replaces it by one of the stop.
  void Next(const RobotState& state, RobotCommand& command) noexcept TWIN_REALTIME;

  /// The limit that the motion would have broken; nullopt: none so far.
  [[nodiscard]] const std::optional<onboard::BrokenLimit>& breach() const noexcept {
    return breach_;
  }

  /// False when, after a breach, there is no command to send: the robot itself stops the arm.
  [[nodiscard]] bool sends() const noexcept { return !breach_ || is_joint_; }

  /// True when the robot is to end the motion: the commanded stop rests, or is the robot's own.
  [[nodiscard]] bool done() const noexcept { return done_; }

 private:
  [[nodiscard]] onboard::JointReference After(const RobotState& state,
                                              const RobotCommand& command) const noexcept;
  [[nodiscard]] std::optional<onboard::BrokenLimit> Check(
      const RobotState& state, const RobotCommand& command) const noexcept;

  control::CommandInterface interface_;
  bool is_joint_;
  JointLimits joints_;
  onboard::StopProof proof_;
  onboard::KinematicCompletion completion_;
  std::optional<onboard::BrokenLimit> breach_;
  bool done_ = false;
};

}  // namespace twin::loop
