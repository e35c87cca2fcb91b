#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "plugins/ros2/arm_commander.h"
#include "plugins/ros2/dds.h"
#include "plugins/ros2/lockstep_answers.h"
#include "plugins/ros2/messages.h"
#include "plugins/ros2/trajectory_goal.h"
#include "twin/core/clock.h"
#include "twin/core/joint_vector.h"
#include "twin/core/time.h"
#include "twin/rt/latest_value.h"

namespace twin::ros2 {

/// Joint positions that a node streams, as ros2_control's topic-based hardware does: sensor_msgs/
/// JointState on robot_joint_commands. The arm follows while the stream is armed and comes.
///
///     off --Arm--> armed: the stream's rate is measured over kMeasured messages
///                  --> follows, from where the arm is --no message for kSilence--> armed
///
/// The rate sets the resampler's lag; so what is late, early, doubled or lost leaves no step in the
/// reference (reference/resampler.h). One node commands at a time, until it is silent for kSilence;
/// none while the arm executes a goal.
/// Messages that are no command for this arm are ignored and told of.
///
/// In lockstep the arm follows from the first command on, and stops when no answer comes in time.
///
/// Threads: Put() one, Arm() and Disarm() any.
/// Source: topic_based_hardware_interfaces 1.1: it names all joints and sends position, velocity
/// and effort of those alone that have that interface.
class JointStream {
 public:
  static constexpr std::size_t kMeasured = 20;
  static constexpr twin::Duration kSilence = std::chrono::milliseconds(500);
  /// Largest distance of the first command from the arm, rad.
  static constexpr double kStartTolerance = 0.1;
  /// A command whose stamp is farther from now is none: a replayed bag, or another clock.
  static constexpr twin::Duration kOldest = std::chrono::seconds(1);

  struct Parts {
    ArmCommander& arm;
    JointNames names;
    JointLimits limits;
    std::function<Time()> now;  ///< of the clock of stamps; any thread
    std::function<void(std::string_view line)> tell;
    /// Time stands until the node has answered, whose rate is then known; absent: it passes.
    std::optional<Lockstep> lockstep{};
  };

  explicit JointStream(Parts parts);

  void Arm();
  void Disarm();
  /// Whether the arm follows it.
  [[nodiscard]] bool is_leading() const;

  /// A message from the network.
  void Put(const msg::JointState& message, const Guid& writer);

 private:
  class Follow;

  /// @returns the positions in the arm's order. @throws InputError saying what is wrong.
  [[nodiscard]] JointVector PositionsOf(const msg::JointState& message) const;
  /// @throws InputError for a stamp that is not of now.
  void RequireTimely(Time stamp) const;
  /// Once a second at most.
  void Complain(std::string_view why);
  void Measure(const JointCommand& command, Time now);
  void BeginToFollow(const JointCommand& command, double rate_hz);

  const Parts parts_;
  const MonotonicClock clock_;
  mutable std::mutex mutex_;  ///< guards the following; never held while the arm moves
  bool is_armed_ = false;
  bool told_unarmed_ = false;
  Guid writer_{};
  std::optional<Time> last_;  ///< of the last command
  std::optional<Time> complained_;
  std::vector<Time> arrivals_;  ///< while the rate is measured
  std::weak_ptr<Follow> current_;
};

}  // namespace twin::ros2
