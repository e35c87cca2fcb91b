#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "twin/core/random.h"
#include "twin/core/realtime.h"
#include "twin/core/robot_command.h"
#include "twin/core/robot_state.h"
#include "twin/onboard/command_inbox.h"
#include "twin/robot/robot_config.h"
#include "twin/rt/delay_model.h"
#include "twin/rt/event_queue.h"

namespace twin::robot {

/// One direction's fate of a message, drawn from the run's seed: lost, or delayed by so much.
class Channel {
 public:
  Channel(const rt::DelayModel& delay, double loss, std::uint64_t seed, RandomStream delay_stream,
          RandomStream loss_stream)
      : delay_(delay),
        loss_(loss),
        delay_random_(seed, delay_stream),
        loss_random_(seed, loss_stream) {}

  /// @param number  of the message; the same number has the same fate.
  [[nodiscard]] bool Loses(std::uint64_t number) const noexcept TWIN_REALTIME {
    return loss_ > 0 && loss_random_.Uniform(number) < loss_;
  }
  [[nodiscard]] Duration Delay(std::uint64_t number) const noexcept TWIN_REALTIME {
    return delay_.Draw(delay_random_, number);
  }

 private:
  rt::DelayModel delay_;
  double loss_;
  Random delay_random_;
  Random loss_random_;
};

/// Robot states on their way to the workstation. Newest id wins: one that arrives behind a newer
/// one is dropped, as libfranka does.
///
/// Threads: the lockstep thread. Real-time: allocates nothing after construction.
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
  void OnEvent(Time now, std::uint64_t message_id) noexcept override;

  Channel channel_;
  rt::EventQueue& events_;
  rt::EventHandler& state_ready_;
  std::vector<RobotState> on_the_way_;  ///< slot = message_id modulo size
  RobotState newest_;
  Time arrival_{};
  bool has_new_ = false;
};

/// Commands on their way to the robot.
///
/// Threads: the lockstep thread. Real-time: allocates nothing after construction.
class CommandLink final : private rt::EventHandler {
 public:
  CommandLink(const LinkConfig& config, std::uint64_t seed, rt::EventQueue& events,
              onboard::CommandInbox& inbox);

  /// Workstation's end.
  void Send(const RobotCommand& command) noexcept TWIN_REALTIME;

 private:
  void OnEvent(Time now, std::uint64_t number) noexcept override;

  Channel channel_;
  rt::EventQueue& events_;
  onboard::CommandInbox& inbox_;
  std::vector<RobotCommand> on_the_way_;  ///< slot = number modulo size
  std::uint64_t sent_ = 0;
};

}  // namespace twin::robot
