#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "plugins/ros2/action_server.h"
#include "plugins/ros2/node.h"
#include "plugins/ros2/simulation_messages.h"
#include "twin/core/joint_vector.h"
#include "twin/server/controlled_robot.h"

namespace twin::ros2 {

/// A simulated robot and what lies around it.
struct Simulation {
  server::ControlledRobot robot;
  /// Lockstep: whether time stands; empty on the wall clock.
  std::function<bool()> is_paused{};
  std::function<std::uint64_t()> cycles_left{};  ///< of steps; as is_paused
  /// Names and poses (X_WB) of the scene's free bodies. Of the publishing thread.
  std::function<std::vector<std::pair<std::string, Transform>>()> bodies;
  bool puts_bodies_on_tf = true;
};

/// simulation_interfaces, by which Gazebo and Isaac Sim are steered too: features, pause, steps,
/// reset, entities. Entities are the scene's free bodies, in the frame `world`.
///
/// Threads: constructor as Node's Serve(); Publish() the publishing thread.
class SimulationServices {
 public:
  SimulationServices(Node& node, Simulation simulation, const std::function<msg::Time()>& now);

  /// Answers steps that have run, and puts bodies on /tf. About every millisecond.
  void Look();

 private:
  using Bodies = std::vector<std::pair<std::string, Transform>>;
  /// Steps under way, and whom to tell.
  struct Steps {
    std::uint64_t all = 0;
    std::function<void(const msg::Result&)> end;
    std::function<void(std::uint64_t left)> tell;  ///< about every 100 ms; may be empty
  };

  void ServeState();
  void ServeEntities();
  void BeginSteps(Steps steps);
  /// The action's.
  void Simulate(const msg::UUID& id, std::uint64_t steps);
  [[nodiscard]] msg::Result Do(const server::ControlRequest& request);
  [[nodiscard]] msg::Result SetState(std::uint8_t state);
  [[nodiscard]] Bodies BodiesNow() const;
  void PublishBodies();

  Node& node_;
  Simulation simulation_;
  const std::function<msg::Time()> now_;
  std::unique_ptr<Publisher<msg::TFMessage>> tf_;
  mutable std::mutex mutex_;  ///< guards the following two
  Bodies bodies_;
  std::optional<Steps> steps_;
  std::atomic<bool> is_canceled_{false};
  int looks_ = 0;
  ActionServer<msg::SimulateSteps> action_;
};

}  // namespace twin::ros2
