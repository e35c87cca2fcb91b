#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "twin/core/hand_command.h"
#include "twin/core/modes.h"
#include "twin/core/realtime.h"
#include "twin/core/robot_state.h"
#include "twin/core/setting.h"
#include "twin/onboard/onboard_controller.h"
#include "twin/plant/plant.h"
#include "twin/record/cycle_record.h"
#include "twin/robot/base_unit.h"
#include "twin/robot/command_keeper.h"
#include "twin/robot/hand_unit.h"
#include "twin/robot/link.h"
#include "twin/robot/robot_config.h"
#include "twin/rt/event_queue.h"

namespace twin::robot {

/// How the last motion ended.
struct LastMotion {
  MoveStatus end = MoveStatus::kMotionStarted;  ///< see onboard::OnboardController::last_end
  onboard::Violations violations;               ///< violations that ended it, if any
};

/// An emulated robot on an event queue: INT, plant, hand, mobile base and link, run by one event
/// per period.
///
/// INT's clock runs clock_ppm faster than the queue's: cycle k is due at
///   t_k = begin + k * 1 ms / (1 + clock_ppm 1e-6),
/// to the nearest nanosecond (exactly k ms after begin without drift). In cycle k
///   INT selects the newest command that answers state k-1 and arrived by t_k - d_INT, else holds;
///   INT checks, integrates, controls;  the plant moves by 1 ms;  state k is filled and sent.
/// The cycle that accepts a motion's first command notifies the plant before it moves.
///
/// The workstation's end: Send() sends a command, and `state_ready` is notified when a state has
/// arrived, which states() returns.
///
/// Threads: that of the event queue. Real-time: all after Begin() is noexcept and allocates
/// nothing.
class Robot final : private rt::EventHandler {
 public:
  /// @param plant  the body; set to config.q_start.
  /// @param state_ready, sink  see backend::Request; sink may be null.
  /// @throws InputError naming the field that is out of range.
  Robot(const RobotConfig& config, std::unique_ptr<plant::Plant> plant, rt::EventQueue& events,
        rt::EventHandler& state_ready, record::RecordSink* sink);

  /// Starts the cycles at the queue's present time; the first is due one period later. Once.
  void Begin() noexcept;

  /// Delays the next cycle and all later ones, as after a stall of INT. Nothing is caught up:
  /// message ids increase by one, only time jumps.
  void Postpone(Duration by) noexcept TWIN_REALTIME;

  /// Due time of the next cycle. @pre after Begin().
  [[nodiscard]] Time next_cycle() const noexcept { return next_cycle_; }
  /// Requests, between two cycles, on the queue's clock.
  [[nodiscard]] Duration period() const noexcept;

  [[nodiscard]] MoveStatus Move(const MotionModes& modes) noexcept;
  void StopMove() noexcept { onboard_.StopMove(); }
  [[nodiscard]] RecoveryStatus AutomaticErrorRecovery() noexcept {
    return onboard_.AutomaticErrorRecovery();
  }
  [[nodiscard]] SetterStatus Configure(const Setting& setting) noexcept {
    return onboard_.Configure(setting);
  }
  [[nodiscard]] bool Operate(PanelAction action) noexcept { return onboard_.Operate(action); }

  /// Whether a hand is mounted. Its requests: see onboard::Gripper. @pre for them: mounted.
  [[nodiscard]] bool has_hand() const noexcept { return hand_.has_value(); }
  [[nodiscard]] HandStart StartHand(const HandCommand& command) noexcept {
    return hand_->Start(command);
  }
  [[nodiscard]] std::optional<HandResult> HandOutcome(HandTicket ticket) const noexcept {
    return hand_->Outcome(ticket);
  }
  [[nodiscard]] HandState hand_state() const noexcept { return hand_->state(); }

  /// The mobile base below the arm, or null.
  [[nodiscard]] BaseUnit* base() noexcept { return base_ ? &*base_ : nullptr; }
  [[nodiscard]] const BaseUnit* base() const noexcept { return base_ ? &*base_ : nullptr; }

  /// Sends a command from the workstation at the queue's present time; the link may lose it.
  void Send(const RobotCommand& command) noexcept TWIN_REALTIME;

  /// The workstation's end of the link.
  [[nodiscard]] StateLink& states() noexcept { return states_; }

  /// Mode of the last cycle (the workstation receives it one link delay later).
  [[nodiscard]] RobotMode mode() const noexcept { return onboard_.robot_mode(); }
  [[nodiscard]] LastMotion last_motion() const noexcept {
    return {onboard_.last_end(), last_violations_};
  }
  /// Violations of the last cycle that had any, with or without a motion; empty before the first.
  [[nodiscard]] const onboard::Violations& last_found() const noexcept { return last_found_; }
  /// Cycles of the running motion without a command, up to the last one.
  [[nodiscard]] std::uint32_t lost_in_row() const noexcept { return onboard_.lost_in_row(); }
  /// Whether, in the last cycle, INT's reference was at rest and every measured joint velocity
  /// below kRestSpeed.
  [[nodiscard]] bool AtRest() const noexcept;

 private:
  void OnEvent(Time now, std::uint64_t token) noexcept override;
  [[nodiscard]] Time Due(std::uint64_t periods) const noexcept;
  void ScheduleCycle() noexcept;
  void OperatePanel() noexcept;
  void Cycle(Time now) noexcept;

  std::unique_ptr<plant::Plant> plant_;
  std::optional<HandUnit> hand_;
  std::optional<BaseUnit> base_;
  onboard::OnboardController onboard_;
  onboard::CommandInbox inbox_;
  rt::EventQueue& events_;
  record::RecordSink* sink_;
  StateLink states_;
  CommandLink commands_;
  Duration d_INT_;
  double clock_speed_;  ///< of INT's clock, relative to the queue's
  std::optional<CommandKeeper> keeper_;
  const std::vector<PanelEvent> panel_;
  std::size_t next_panel_event_ = 0;

  Time begin_{};
  std::uint64_t periods_ = 0;  ///< from begin_ to the next cycle, without postponements
  Time next_cycle_{};
  onboard::Violations last_violations_;
  onboard::Violations last_found_;
  record::CycleRecord record_;
};

}  // namespace twin::robot
