#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "twin/core/realtime.h"
#include "twin/core/robot_command.h"
#include "twin/core/robot_state.h"
#include "twin/onboard/int.h"
#include "twin/plant/plant.h"
#include "twin/robot/link.h"
#include "twin/robot/robot_config.h"
#include "twin/rt/cycle_record.h"
#include "twin/rt/event_queue.h"

namespace twin::robot {

/// A whole emulated robot on the virtual clock: INT, plant and link, run by one event a
/// millisecond.
///
/// Cycle k at t_k = k ms:
///   select the newest command that answers state k-1 and arrived by t_k - d_INT, else hold;
///   INT checks, integrates, controls;  the plant moves by 1 ms;  state k is filled and sent.
///
/// Its workstation end: Send() puts a command on the way, and `state_ready` is told when a state
/// has come through, to be taken with link().
///
/// Threads: the lockstep thread. Real-time: OnEvent() and Send() allocate nothing.
class Robot final : private rt::EventHandler {
 public:
  /// Starts the cycles; the first is due at 1 ms.
  /// @param plant  the body; moved to config.q_start.
  /// @param state_ready, sink  see backend::Request; sink may be null.
  /// @throws InputError naming the field that is out of range.
  Robot(const RobotConfig& config, std::unique_ptr<plant::Plant> plant, rt::EventQueue& events,
        rt::EventHandler& state_ready, rt::RecordSink* sink);

  [[nodiscard]] onboard::MoveStatus Move(const MotionModes& modes) noexcept;
  void StopMove() noexcept { int_.StopMove(); }
  [[nodiscard]] onboard::RecoveryStatus AutomaticErrorRecovery() noexcept {
    return int_.AutomaticErrorRecovery();
  }
  [[nodiscard]] onboard::SetterStatus SetJointImpedance(const JointVector& K_theta) noexcept {
    return int_.SetJointImpedance(K_theta);
  }

  /// Sends a command from the workstation; it may be lost on the way.
  void Send(const RobotCommand& command) noexcept TWIN_REALTIME;

  /// The workstation's end of the link.
  [[nodiscard]] StateLink& states() noexcept { return states_; }

  /// The robot's mode as of its last cycle (the workstation sees it one link delay later).
  [[nodiscard]] RobotMode mode() const noexcept { return int_.robot_mode(); }
  /// How the last motion ended.
  [[nodiscard]] onboard::MoveStatus last_end() const noexcept { return int_.last_end(); }
  /// What ended it, when an error did.
  [[nodiscard]] const onboard::Violations& last_violations() const noexcept {
    return last_violations_;
  }

 private:
  void OnEvent(Time now, std::uint64_t token) noexcept override;

  std::unique_ptr<plant::Plant> plant_;
  onboard::Int int_;
  onboard::CommandInbox inbox_;
  rt::EventQueue& events_;
  rt::RecordSink* sink_;
  StateLink states_;
  CommandLink commands_;
  Duration d_INT_;
  onboard::Violations last_violations_;
  rt::CycleRecord record_;
};

}  // namespace twin::robot
