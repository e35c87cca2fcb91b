#pragma once

#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>

#include "twin/control/registry.h"
#include "twin/record/cycle_record.h"
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
/// It connects for each work, so that other clients can command the robot in between; or once, and
/// then passes the robot's states on while nothing is done, and connects anew when the robot is
/// gone.
///
/// Threads: any.
class ArmCommander {
 public:
  struct Parts {
    const run::Catalogue& catalogue;
    run::RunFiles files;
    scenario::Scenario client;     ///< application::OwnClientOf
    run::RealtimeConfig settings;  ///< where it connects
    /// Receives the states of a connection that is kept; null: it connects for each work.
    record::RecordSink* states = nullptr;
    std::function<void(std::string_view line)> tell{};
  };

  explicit ArmCommander(Parts parts);
  /// Stops what is under way.
  ~ArmCommander();

  void Begin(std::shared_ptr<ArmWork> work);
  /// Unless it is busy. @returns whether it begins.
  [[nodiscard]] bool TryBegin(std::shared_ptr<ArmWork> work);
  /// Wishes the end of this work, under way or waiting.
  void GiveUp(const ArmWork& work);
  [[nodiscard]] bool is_busy() const;

 private:
  void Run(const std::stop_token& stop);
  /// Connects, and executes works until there is none, or for ever.
  void Serve(const std::stop_token& stop);
  void Execute(run::Session& session);
  /// The next work becomes the current one. @returns whether there was one.
  bool TakeNext(const std::stop_token& stop);
  /// The current work is over.
  void End(const std::string& why);

  const Parts parts_;
  control::ControllerRegistry controllers_;  ///< the program's, and that of the current work
  mutable std::mutex mutex_;                 ///< guards the following three
  std::condition_variable_any wake_;
  std::shared_ptr<ArmWork> next_;
  std::shared_ptr<ArmWork> current_;
  volatile bool interrupted_ = false;  ///< read by the session
  std::jthread thread_;
};

}  // namespace twin::ros2
