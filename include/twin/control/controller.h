#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "twin/control/parameters.h"
#include "twin/core/realtime.h"
#include "twin/core/robot_state.h"
#include "twin/core/time.h"
#include "twin/reference/target.h"

namespace twin::control {

/// The commanded quantity; a controller claims exactly one.
enum class CommandInterface : std::uint8_t {
  kJointPosition,
  kJointVelocity,
  kCartesianPose,
  kTorque,  ///< the robot adds gravity and friction compensation
};

/// Result of one update. All values are zero at first and persist between updates; the controller
/// overwrites those it commands.
struct ControllerOutput {
  reference::Target target;
  /// True: the controller gives the velocity (or twist) of a position-type target. False: it is
  /// formed from successive positions where they are deposited.
  bool has_velocity = false;
  /// False: the source has given nothing new since the last Update; nothing is deposited. For
  /// sources with a clock of their own, such as a program that streams its targets.
  bool fresh = true;
  /// When the source sampled the target, on the source's clock; absent: at `now`.
  std::optional<Time> sampled_at{};
  bool finished = false;  ///< the task is done; the target is its end pose, at rest
  /// The task cannot be done: no more commands are sent, the robot is stopped, the run fails, and
  /// Controller::Explain() gives the reason.
  bool failed = false;
};

/// A user's control law. A loop calls it at its own rate and clock, above the 1 kHz tick.
///
/// It claims one command interface. ControllerRequest brings reference and model at construction;
/// Configure() brings gains and other parameters. Life: Configure once; then per motion Activate
/// once, Update once per period, Deactivate. Threads: one at a time, in this order. Real-time:
/// Update() is noexcept and does not allocate, free, lock, wait or log.
///
/// The class crosses shared-library boundaries: its calls pass plain data, or standard containers
/// of the same compiler. Raise kControllerLibraryAbi (controller_library.h) when a layout here
/// changes.
class Controller {
 public:
  virtual ~Controller() = default;

  /// Constant over the controller's life.
  [[nodiscard]] virtual CommandInterface command_interface() const noexcept = 0;

  /// Reads the scenario's parameters, each by key with default, unit and range. The caller refuses
  /// keys that were not read.
  /// @throws InputError as ParameterReader's functions do, and for values that contradict each
  /// other.
  virtual void Configure(ParameterReader& /*parameters*/) {}

  /// @param state  fresh state of the robot at rest.
  /// @throws InputError giving the reason if the motion cannot start from there.
  virtual void Activate(const RobotState& state, Time now) = 0;

  /// @param state   newest state that the communication loop published.
  /// @param now     time of the loop's clock; the period is the time since the last call.
  virtual void Update(const RobotState& state, Time now,
                      ControllerOutput& output) noexcept TWIN_REALTIME = 0;

  virtual void Deactivate() noexcept = 0;

  /// True if the task is an end-effector pose, so that the joint error at the end is meaningless.
  /// Used by the report of a run.
  [[nodiscard]] virtual bool follows_pose() const noexcept { return false; }

  /// Message for users on why the last Update() set `failed`: what, where, value, bound and cure.
  /// Empty if it did not. Called after the last Update().
  [[nodiscard]] virtual std::string Explain() const { return {}; }
};

}  // namespace twin::control
