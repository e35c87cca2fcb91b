#pragma once

#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "twin/backend/hand.h"
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

/// Commands a hand for ROS nodes: one command at a time, on a thread of its own. A new command ends
/// the one under way. It holds the hand for as long as a command takes.
///
/// Threads: any.
class HandCommander {
 public:
  using Connect = std::function<std::shared_ptr<backend::Hand>()>;
  explicit HandCommander(Connect connect);
  ~HandCommander();

  void Begin(HandWork work);
  /// Stops what is under way.
  void Stop();

 private:
  void Run(const std::stop_token& stop);
  void Execute(const HandWork& work);

  const Connect connect_;
  std::mutex mutex_;  ///< guards the following two
  std::condition_variable_any wake_;
  std::optional<HandWork> next_;
  bool stops_ = false;
  std::jthread thread_;
};

}  // namespace twin::ros2
