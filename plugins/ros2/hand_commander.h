#pragma once

#include <condition_variable>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "twin/core/hand_command.h"

namespace twin::ros2 {

/// A command to the hand for a ROS node, and what becomes of it. All are called on the commander's
/// thread.
struct HandWork {
  /// Chooses the command by the hand's present state. @throws InputError when none fits.
  std::function<HandCommand(const HandState&)> choose;
  /// About every 50 ms.
  std::function<void(const HandState&)> look;
  /// @param result  absent: it was not begun, or the hand is gone. @param why  the reason, for
  /// users; empty: none.
  std::function<void(std::optional<HandResult> result, const HandState& state,
                     const std::string& why)>
      end;
};

/// Commands a hand for ROS nodes: one command at a time, on a thread of its own, connected for as
/// long as the command takes, so that others can command the hand in between. A new command ends
/// the one under way.
///
/// Threads: any.
class HandCommander {
 public:
  HandCommander(std::string host, std::uint16_t port);
  ~HandCommander();

  void Begin(HandWork work);
  /// Stops what is under way.
  void Stop();

 private:
  void Run(const std::stop_token& stop);
  void Execute(const HandWork& work);

  const std::string host_;
  const std::uint16_t port_;
  std::mutex mutex_;  ///< guards the following two
  std::condition_variable_any wake_;
  std::optional<HandWork> next_;
  bool stops_ = false;
  std::jthread thread_;
};

}  // namespace twin::ros2
