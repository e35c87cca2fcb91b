#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <utility>

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
  MoveStatus end = MoveStatus::kMotionStarted;   ///< see onboard::OnboardController::last_end
  onboard::Violations violations;                ///< violations that ended it, if any
  std::optional<onboard::BrokenLimit> breach{};  ///< the guard's limit that ended it, if one did
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

  /// Begins anew with the arm at rest at `q`, between two cycles and not in a motion: plant, hand,
  /// base and INT as constructed. Message ids, time, panel events and the links go on, and with
  /// them the links' random losses. Not for real time: allocates.
  void Reset(const JointVector& q);

  /// Draws all that is random from now on anew: what the link does to later messages, and the
  /// noise of the sensors. Between two events. Not for real time: allocates.
  /// @param link  whose delays and losses count from now on; its d_INT does not.
  /// @throws InputError naming the field that is out of range.
  void Renew(const LinkConfig& link, std::uint64_t seed);

  /// A copy of all that changes in a robot: plant, hand, base, INT and both directions of its link.
  /// The messages in flight arrive by events, so whoever owns the queue keeps a copy of it, too.
  class Snapshot;
  /// Between two events. Not for real time, like Restore(): allocates.
  [[nodiscard]] Snapshot Save() noexcept;
  /// Goes back, in the middle of a motion too: the same commands and requests then give the same
  /// bits as after Save(), message ids, random losses and delays included. Only the times of the
  /// records that the sink gets (CycleRecord::at) go on from the last one.
  /// @pre `snapshot` is of this robot; the queue was, or will be, taken back with it.
  void Restore(const Snapshot& snapshot) noexcept;

  /// How much later the records' times are than the queue's: what Restore() took back.
  [[nodiscard]] Duration records_ahead() const noexcept { return live_.ahead; }

  /// As plant::Plant. Between two events.
  std::optional<plant::Overlap> Place(int body, const Transform& X_WB) noexcept TWIN_REALTIME {
    return plant_->Place(body, X_WB);
  }

  [[nodiscard]] const RobotConfig& config() const noexcept { return config_; }

  /// From now on INT only holds the arm: the sink gets no more records. Between two events.
  void StandBy() noexcept;
  /// As plant::Plant.
  [[nodiscard]] bool is_awaited() const noexcept { return plant_->is_awaited(); }

  /// Starts the cycles at the queue's present time; the first is due one period later. Once.
  void Begin() noexcept;

  /// Delays the next cycle and all later ones, as after a stall of INT. Nothing is caught up:
  /// message ids increase by one, only time jumps.
  void Postpone(Duration by) noexcept TWIN_REALTIME;

  /// Due time of the next cycle. @pre after Begin().
  [[nodiscard]] Time next_cycle() const noexcept { return live_.next_cycle; }
  /// Requests, between two cycles, on the queue's clock.
  [[nodiscard]] Duration period() const noexcept;

  [[nodiscard]] MoveStatus Move(const MotionModes& modes) noexcept;
  void StopMove() noexcept { live_.onboard.StopMove(); }
  [[nodiscard]] RecoveryStatus AutomaticErrorRecovery() noexcept {
    return live_.onboard.AutomaticErrorRecovery();
  }
  [[nodiscard]] SetterStatus Configure(const Setting& setting) noexcept {
    return live_.onboard.Configure(setting);
  }
  [[nodiscard]] bool Operate(PanelAction action) noexcept { return live_.onboard.Operate(action); }

  /// Whether a hand is mounted, of the kind that the config says. Its requests: see
  /// onboard::Gripper and onboard::VacuumPump. @pre for them: mounted.
  [[nodiscard]] bool has_hand() const noexcept { return live_.hand.has_value(); }
  [[nodiscard]] HandStart StartHand(const HandCommand& command) noexcept {
    return live_.hand->Start(command);
  }
  [[nodiscard]] std::optional<HandResult> HandOutcome(HandTicket ticket) const noexcept {
    return live_.hand->Outcome(ticket);
  }
  [[nodiscard]] HandState hand_state() const noexcept { return live_.hand->state(); }

  /// The mobile base below the arm, or null.
  [[nodiscard]] BaseUnit* base() noexcept { return base_ ? &*base_ : nullptr; }
  [[nodiscard]] const BaseUnit* base() const noexcept { return base_ ? &*base_ : nullptr; }

  /// Sends a command from the workstation at the queue's present time; the link may lose it.
  void Send(const RobotCommand& command) noexcept TWIN_REALTIME;

  /// The workstation's end of the link.
  [[nodiscard]] StateLink& states() noexcept { return live_.states; }

  /// Mode of the last cycle (the workstation receives it one link delay later).
  [[nodiscard]] RobotMode mode() const noexcept { return live_.onboard.robot_mode(); }
  [[nodiscard]] LastMotion last_motion() const noexcept {
    return {live_.onboard.last_end(), live_.last_violations, live_.onboard.guard_breach()};
  }
  /// The limits that INT guards; empty: none. Constant.
  [[nodiscard]] const model::LabLimits& guard() const noexcept { return config_.onboard.guard; }
  /// The last state that INT sent; zero before the first.
  [[nodiscard]] const RobotState& state() const noexcept { return live_.record.state; }
  /// As state(), and before the first cycle what a state would be now, with message_id 0.
  [[nodiscard]] RobotState Peek() const noexcept;
  /// Violations of the last cycle that had any, with or without a motion; empty before the first,
  /// also after Reset() and Restore().
  [[nodiscard]] const onboard::Violations& last_found() const noexcept { return live_.last_found; }
  /// An asynchronous motion is under way, whose commands come at any time.
  [[nodiscard]] bool is_asynchronous() const noexcept { return live_.onboard.is_asynchronous(); }
  /// Cycles of the running motion without a command, up to the last one.
  [[nodiscard]] std::uint32_t lost_in_row() const noexcept { return live_.onboard.lost_in_row(); }
  /// Whether, in the last cycle, INT's reference was at rest and every measured joint velocity
  /// below kRestSpeed.
  [[nodiscard]] bool AtRest() const noexcept;

 private:
  /// All that changes beside plant and base, which have States of their own.
  struct Live {
    onboard::OnboardController onboard;
    std::optional<HandUnit> hand{};
    onboard::CommandInbox inbox{};
    StateLink states;
    CommandLink commands;  ///< into the inbox
    std::size_t next_panel_event = 0;
    Time begin{};
    std::uint64_t periods = 0;  ///< from begin to the next cycle, without postponements
    Time next_cycle{};
    onboard::Violations last_violations{};
    onboard::Violations last_found{};
    record::CycleRecord record{};
    Duration ahead{};  ///< of the records' times before the queue's, by Restore()
  };

  void OnEvent(Time now, std::uint64_t token) noexcept override;
  /// Plant, hand and base as at the beginning, the arm at `q`.
  void ResetBodies(const JointVector& q);
  [[nodiscard]] Time Due(std::uint64_t periods) const noexcept;
  void ScheduleCycle() noexcept;
  void OperatePanel() noexcept;
  void Cycle(Time now) noexcept;

  const RobotConfig config_;
  std::unique_ptr<plant::Plant> plant_;
  std::optional<BaseUnit> base_;
  rt::EventQueue& events_;
  record::RecordSink* sink_;  ///< null: none, or standing by
  const Duration d_INT_;
  const double clock_speed_;  ///< of INT's clock, relative to the queue's
  std::optional<CommandKeeper> keeper_;
  Live live_;
};

class Robot::Snapshot {
 public:
  /// Id of the last state that INT sent.
  [[nodiscard]] std::uint64_t message_id() const noexcept { return live_.record.state.message_id; }

 private:
  friend class Robot;
  Snapshot(const Live& live, std::unique_ptr<const plant::Plant::State> plant,
           std::optional<BaseUnit::State> base)
      : live_(live), plant_(std::move(plant)), base_(base) {}

  Live live_;
  std::unique_ptr<const plant::Plant::State> plant_;
  std::optional<BaseUnit::State> base_;
};

}  // namespace twin::robot
