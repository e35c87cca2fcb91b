#pragma once

#include <cstdint>
#include <optional>

#include "twin/core/realtime.h"
#include "twin/core/robot_state.h"
#include "twin/onboard/command_inbox.h"
#include "twin/robot/channel.h"
#include "twin/robot/robot_config.h"
#include "twin/rt/event_queue.h"

namespace twin::robot {

/// Robot states in flight to the workstation. The newest id wins: a state that arrives after a
/// newer one, or a second time, is dropped, as in libfranka.
///
/// Threads: that of the event queue. Real-time: allocates nothing after construction.
class StateLink final : private rt::EventHandler {
 public:
  StateLink(const LinkConfig& config, std::uint64_t seed, rt::EventQueue& events,
            rt::EventHandler& state_ready);

  /// As Channel::Renew().
  void Renew(const LinkConfig& config, std::uint64_t seed) {
    channel_.Renew(config.state, seed, faults::kStateStreams);
  }

  /// For the robot.
  void Send(const RobotState& state) noexcept TWIN_REALTIME;

  /// For the workstation. Whether a state has arrived since the last Take().
  [[nodiscard]] bool has_new() const noexcept { return has_new_; }
  /// Arrival time of the newest state.
  [[nodiscard]] Time arrival() const noexcept { return arrival_; }
  /// For the workstation. Takes the newest state. @pre a state has arrived.
  [[nodiscard]] const RobotState& Take() noexcept {
    has_new_ = false;
    return newest_;
  }

 private:
  void OnEvent(Time now, std::uint64_t token) noexcept override;

  Channel<RobotState> channel_;
  rt::EventHandler* state_ready_;
  RobotState newest_;
  Time arrival_{};
  bool has_new_ = false;
};

/// Commands in flight to the robot. The state it answers is the key of a command's fate, so the
/// number of earlier commands does not change it. All arrivals enter the inbox, including
/// duplicates and overtaken ones; the inbox decides.
///
/// Threads: that of the event queue. Real-time: allocates nothing after construction.
class CommandLink final : private rt::EventHandler {
 public:
  CommandLink(const LinkConfig& config, std::uint64_t seed, rt::EventQueue& events,
              onboard::CommandInbox& inbox);

  /// As Channel::Renew().
  void Renew(const LinkConfig& config, std::uint64_t seed) {
    channel_.Renew(config.command, seed, faults::kCommandStreams);
  }

  /// For the workstation.
  void Send(const RobotCommand& command) noexcept TWIN_REALTIME;

 private:
  void OnEvent(Time now, std::uint64_t token) noexcept override;

  Channel<RobotCommand> channel_;
  onboard::CommandInbox* inbox_;
  std::optional<std::uint64_t> last_answered_;
  std::uint32_t repeat_ = 0;
};

}  // namespace twin::robot
