#pragma once

#include <condition_variable>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "twin/control/registry.h"
#include "twin/run/catalogue.h"
#include "twin/run/run.h"
#include "twin/run/session.h"
#include "twin/scenario/scenario.h"

namespace twin::ros2 {

/// Something that the arm does for a ROS node. All are called on the commander's thread.
class ArmWork {
 public:
  virtual ~ArmWork() = default;
  /// @throws Error when it cannot begin, or has failed.
  virtual void Run(run::Session& session, const scenario::Scenario& client) = 0;
  /// Of a motion whose controller's type is kController.
  [[nodiscard]] virtual std::unique_ptr<control::Controller> MakeController(
      const control::ControllerRequest& /*request*/) {
    return nullptr;
  }
  /// About every 100 ms of a motion.
  virtual void Look() {}
  /// After Run(), or in its place. @param why  it failed; empty: all went well. @param gave_up
  /// somebody wished its early end.
  virtual void End(const std::string& why, bool gave_up) = 0;
};

/// Runs a motion by a work's own controller, from where the arm rests. @throws RobotFault when the
/// robot is not Idle; as Session::Move.
[[nodiscard]] run::MotionResult MoveByOwnController(run::Session& session, run::Motion motion);

/// @throws RobotFault, saying what to do, when the robot is not Idle.
void RequireReady(const RobotState& state);

/// Name of a work's controller.
inline constexpr const char* kController = "ros2";

/// Moves an arm for ROS nodes: one work at a time, on a thread of its own, as an ordinary client of
/// the robot with the whole command chain before it. A new work ends the one under way, whose arm
/// comes to rest first.
///
/// Threads: any.
class ArmCommander {
 public:
  struct Parts {
    const run::Catalogue& catalogue;
    run::RunFiles files;
    scenario::Scenario client;     ///< application::OwnClientOf
    run::RealtimeConfig settings;  ///< where it connects
  };

  explicit ArmCommander(Parts parts);
  /// Stops what is under way.
  ~ArmCommander();

  void Begin(std::shared_ptr<ArmWork> work);
  /// Wishes the end of this work, under way or waiting.
  void GiveUp(const ArmWork& work);
  [[nodiscard]] bool is_busy() const;

 private:
  void Run(const std::stop_token& stop);
  void Execute(const std::shared_ptr<ArmWork>& work);

  const Parts parts_;
  mutable std::mutex mutex_;  ///< guards the following three
  std::condition_variable_any wake_;
  std::shared_ptr<ArmWork> next_;
  std::shared_ptr<ArmWork> current_;
  volatile bool interrupted_ = false;  ///< read by the session
  std::jthread thread_;
};

}  // namespace twin::ros2
