#pragma once

#include <cstdint>
#include <optional>

#include "twin/core/realtime.h"
#include "twin/core/robot_command.h"
#include "twin/core/robot_state.h"
#include "twin/onboard/command_inbox.h"
#include "twin/robot/channel.h"
#include "twin/robot/link_config.h"
#include "twin/rt/event_queue.h"

namespace twin::robot {

/// Robot states on their way to the workstation. Newest id wins: one that arrives behind a newer
/// one, or a second time, is dropped, as libfranka does.
///
/// Threads: that of the event queue. Real-time: allocates nothing after construction.
class StateLink final : private rt::EventHandler {
 public:
  StateLink(const LinkConfig& config, std::uint64_t seed, rt::EventQueue& events,
            rt::EventHandler& state_ready);

  /// Robot's end.
  void Send(const RobotState& state) noexcept TWIN_REALTIME;

  /// Workstation's end. Whether a state has arrived that Take() has not given yet.
  [[nodiscard]] bool has_new() const noexcept { return has_new_; }
  /// When the newest state arrived.
  [[nodiscard]] Time arrival() const noexcept { return arrival_; }
  /// Workstation's end. The newest state; it counts as read. @pre a state has arrived.
  [[nodiscard]] const RobotState& Take() noexcept {
    has_new_ = false;
    return newest_;
  }

 private:
  void OnEvent(Time now, std::uint64_t token) noexcept override;

  Channel<RobotState> channel_;
  rt::EventHandler& state_ready_;
  RobotState newest_;
  Time arrival_{};
  bool has_new_ = false;
};

/// Commands on their way to the robot. The fate of a command is keyed by the state it answers, so
/// that how many commands were sent before does not change what happens to this one. All that
/// arrives goes into the inbox, second copies and overtaken ones too; the inbox decides.
///
/// Threads: that of the event queue. Real-time: allocates nothing after construction.
class CommandLink final : private rt::EventHandler {
 public:
  CommandLink(const LinkConfig& config, std::uint64_t seed, rt::EventQueue& events,
              onboard::CommandInbox& inbox);

  /// Workstation's end.
  void Send(const RobotCommand& command) noexcept TWIN_REALTIME;

 private:
  void OnEvent(Time now, std::uint64_t token) noexcept override;

  Channel<RobotCommand> channel_;
  onboard::CommandInbox& inbox_;
  std::optional<std::uint64_t> last_answered_;
  std::uint32_t repeat_ = 0;
};

}  // namespace twin::robot
