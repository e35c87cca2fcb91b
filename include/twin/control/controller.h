#pragma once

#include <cstdint>
#include <string>

#include "twin/control/parameters.h"
#include "twin/core/realtime.h"
#include "twin/core/robot_state.h"
#include "twin/core/time.h"
#include "twin/reference/target.h"

namespace twin::control {

/// Which quantity a controller commands; one controller claims exactly one.
enum class CommandInterface : std::uint8_t {
  kJointPosition,
  kJointVelocity,
  kCartesianPose,
  kTorque,  ///< the robot adds gravity and friction compensation
};

/// What a controller gives in one update. A fresh one has all values zero; between updates it is
/// kept, and the controller overwrites what it commands.
struct ControllerOutput {
  reference::Target target;
  /// The velocity (or twist) of a position-type target is the source's own; otherwise it is formed
  /// from successive positions where they are deposited.
  bool has_velocity = false;
  bool finished = false;  ///< the task is done; the target is its end, at rest
  /// The task cannot be done: nothing more is sent, the robot is stopped, the run fails, and
  /// Controller::Explain() says why.
  bool failed = false;
};

/// A user's control law, run by a loop of its own rate and clock above the 1 kHz tick.
///
/// It claims one command interface. Reference and model come with its ControllerRequest at
/// construction, gains and the like by Configure(). Life: Configure once; then per motion Activate
/// once, Update once per period, Deactivate. Threads: one at a time, in this order. Real-time:
/// Update() is noexcept, takes and frees no memory, locks, waits, logs and throws not.
///
/// The class crosses the border of shared libraries: what its calls pass is plain data, or a
/// standard container of the same compiler. Whatever changes a layout here raises
/// kControllerLibraryAbi (controller_library.h).
class Controller {
 public:
  virtual ~Controller() = default;

  /// The same during the whole life.
  [[nodiscard]] virtual CommandInterface command_interface() const noexcept = 0;

  /// Takes the parameters of the scenario. Each is asked for by its key, with default, unit and
  /// range; what is left over in the end is refused by the caller.
  /// @throws InputError as ParameterReader's functions; and for values that do not go together.
  virtual void Configure(ParameterReader& /*parameters*/) {}

  /// @param state  a fresh state of the robot at rest.
  /// @throws InputError when the motion cannot start from there, saying why.
  virtual void Activate(const RobotState& state, Time now) = 0;

  /// @param state   newest state the communication side has published.
  /// @param now     the loop's own time; the time since the last call is the period.
  virtual void Update(const RobotState& state, Time now,
                      ControllerOutput& output) noexcept TWIN_REALTIME = 0;

  virtual void Deactivate() noexcept = 0;

  /// Whether the task is a pose of the end effector, so that the joints' own distance from the goal
  /// says nothing. For the report of a run.
  [[nodiscard]] virtual bool follows_pose() const noexcept { return false; }

  /// Why the last update said failed, for people: what, where, the value and the bound, the cure.
  /// Empty when none did. Called after the last Update().
  [[nodiscard]] virtual std::string Explain() const { return {}; }
};

}  // namespace twin::control
