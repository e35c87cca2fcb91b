#pragma once

#include <cstdint>

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

/// What a controller gives in one update.
struct ControllerOutput {
  reference::Target target;
  /// The velocity (or twist) of a position-type target is the source's own; otherwise it is formed
  /// from successive positions where they are deposited.
  bool has_velocity = false;
  bool finished = false;  ///< the task is done; the target is its end, at rest
};

/// A user's control law, run by a loop of its own rate and clock above the 1 kHz tick.
///
/// Life: Activate once per motion, then Update once per period, then Deactivate. Threads: all calls
/// from the controller loop's thread. Real-time: Update() is noexcept and allocates nothing.
class Controller {
 public:
  virtual ~Controller() = default;

  [[nodiscard]] virtual CommandInterface command_interface() const noexcept = 0;

  /// @param state  a fresh state of the robot at rest.
  /// @throws InputError when the motion cannot start from there, saying why.
  virtual void Activate(const RobotState& state, Time now) = 0;

  /// @param state   newest state the communication side has published.
  /// @param now     the loop's own time.
  virtual void Update(const RobotState& state, Time now,
                      ControllerOutput& output) noexcept TWIN_REALTIME = 0;

  virtual void Deactivate() noexcept = 0;
};

}  // namespace twin::control
