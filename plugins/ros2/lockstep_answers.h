#pragma once

#include <condition_variable>
#include <functional>
#include <mutex>
#include <optional>

#include "twin/core/joint_vector.h"
#include "twin/core/robot_state.h"
#include "twin/core/time.h"

namespace twin::ros2 {

/// Positions from the network, and the time of the sender's clock at which they were sampled.
struct JointCommand {
  JointVector q{};
  Time sampled_at{};
};

/// Lets time stand until a node has answered: the robot's time, which waits for its own client,
/// waits for whoever it waits for.
struct Lockstep {
  int period_cycles = 10;  ///< a state is published, and awaited an answer to, every so many
  twin::Duration timeout = std::chrono::seconds(10);
  /// Publishes a state. @returns its stamp.
  std::function<Time(const RobotState&)> publish;
};

/// Commands by which a node answers states. One answers a state when it was sampled at the state's
/// stamp or later.
///
/// Threads: any.
class LockstepAnswers {
 public:
  void Put(const JointCommand& command) {
    const std::lock_guard lock(mutex_);
    newest_ = command;
    came_.notify_all();
  }
  /// Ends all waiting.
  void Stop() {
    const std::lock_guard lock(mutex_);
    is_stopped_ = true;
    came_.notify_all();
  }
  [[nodiscard]] bool is_stopped() {
    const std::lock_guard lock(mutex_);
    return is_stopped_;
  }
  /// @returns the answer to the state of this stamp; nullopt after the timeout, or Stop().
  [[nodiscard]] std::optional<JointCommand> Await(Time stamp, twin::Duration timeout) {
    std::unique_lock lock(mutex_);
    const auto is_answered = [&] { return newest_ && newest_->sampled_at >= stamp; };
    came_.wait_for(lock, timeout, [&] { return is_stopped_ || is_answered(); });
    return !is_stopped_ && is_answered() ? newest_ : std::nullopt;
  }

 private:
  std::mutex mutex_;  ///< guards the following
  std::condition_variable came_;
  std::optional<JointCommand> newest_;
  bool is_stopped_ = false;
};

}  // namespace twin::ros2
