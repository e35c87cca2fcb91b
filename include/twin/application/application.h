#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "twin/application/evidence.h"
#include "twin/application/task.h"
#include "twin/control/controller.h"
#include "twin/core/clock.h"
#include "twin/core/joint_vector.h"
#include "twin/core/time.h"
#include "twin/planning/collision_world.h"
#include "twin/record/log_records.h"
#include "twin/reference/trajectory.h"
#include "twin/run/run.h"
#include "twin/run/session.h"
#include "twin/scenario/scenario.h"
#include "twin/teleop/device_registry.h"

namespace twin::application {

/// A performed task.
struct TaskResult {
  TaskReport task;
  std::vector<record::PlanRecord> plans{};  ///< motions that the report shows in pairs of pictures
  Duration planning_time{};                 ///< on the wall clock, so it does not repeat
};

/// True if the task succeeded and every demand is met.
[[nodiscard]] bool Succeeded(const TaskResult& task_result, const Evaluation& evaluation) noexcept;

/// The failed step, else the first missed demand; empty after a success.
[[nodiscard]] std::string FailureOf(const TaskResult& task_result, const Evaluation& evaluation);

/// The robot and the world that an application works with. All references must outlive it.
///
/// Threads: one thread.
struct Stage {
  run::Session& session;
  const scenario::Scenario& scenario;
  const run::RunFiles& files;
  const Clock& clock;  ///< wall clock, only to measure how long planning takes
  const teleop::DeviceRegistry* devices = nullptr;  ///< of operators; null: there are none
  std::function<void(std::string_view)> tell{};  ///< receives one log line per event; may be empty

  /// End effector in the flange, as configured in the robot.
  [[nodiscard]] Transform F_T_EE() const;
  /// A world to plan in: the scenario's scene and robot. @throws as planning::CollisionWorld.
  [[nodiscard]] std::unique_ptr<planning::CollisionWorld> MakeWorld() const;
  /// Runs application::Carry() on the session's time; reports each attempt to `tell` and the log.
  [[nodiscard]] TaskReport Carry(const std::vector<TaskStep>& steps) const;
};

/// Performs a whole task by motions and hand commands, on any drive, and evaluates the result.
///
/// Threads: one thread. Not for real-time code.
class Application {
 public:
  virtual ~Application() = default;

  /// Checks a scenario before any connection is made.
  /// @throws InputError naming what is missing, with file and line.
  virtual void Require(const scenario::Scenario& /*scenario*/) const {}
  /// Whether the application supports a mobile base, where O moves; the others refuse one.
  [[nodiscard]] virtual bool drives_base() const noexcept { return false; }

  /// Interface of the first motion: the robot must grant it before anything moves.
  [[nodiscard]] virtual control::CommandInterface first_interface() const noexcept = 0;
  /// Upper bound of the duration, robot's time; the video ends there.
  [[nodiscard]] virtual Duration longest(const scenario::Scenario& scenario) const = 0;

  /// @throws InputError for a scenario that cannot be carried out; RobotFault outside of steps.
  [[nodiscard]] virtual TaskResult Perform(Stage& stage) = 0;

  /// Called once, after the session has ended, also after a failure.
  [[nodiscard]] virtual Evaluation Evaluate(const TaskResult& task_result,
                                            const Evidence& evidence) = 0;
};

/// The application that a scenario names, with its parameters. @pre scenario.application.
/// @throws InputError for an unknown name or an invalid parameter, with file and line.
[[nodiscard]] std::unique_ptr<Application> Make(const scenario::Scenario& scenario);

/// Points of a path for a picture: the first, then each at least 2 cm from the last; wider apart
/// where they exceed render::Ghost::kMostPoints. Threads: any. @pre `points` is not empty.
[[nodiscard]] std::vector<Vector3> Thinned(const std::vector<Vector3>& points);

/// Path of the end effector along a trajectory, base frame, m, thinned. Threads: any.
/// @param F_T_EE  end effector in the flange.
[[nodiscard]] std::vector<Vector3> EndEffectorPath(const reference::Trajectory& trajectory,
                                                   const Transform& F_T_EE);

/// An application on its robot: construct -> [CheckStart] -> Execute -> Evaluate.
///
/// Threads: one thread.
class ApplicationRun {
 public:
  /// Connects the robot. @param sink, settings  as run::Run's. @param clock  as Stage::clock.
  /// All references must outlive this.
  /// @throws InputError for a scenario without an application, and as Make() and run::Session.
  ApplicationRun(const scenario::Scenario& scenario, const run::Catalogue& catalogue,
                 const run::RunFiles& files, record::RecordSink* sink, const Clock& clock,
                 const run::RealtimeSettings& settings = {});

  [[nodiscard]] const backend::Connection& connection() const { return session_.connection(); }
  [[nodiscard]] const scenario::RobotData& robot() const { return session_.robot(); }
  /// As Application's.
  [[nodiscard]] Duration longest() const { return application_->longest(scenario_); }
  /// As run::Run::CheckStart.
  [[nodiscard]] bool CheckStart(const run::TellCheck& tell);

  /// The whole session, once. @param tell  as Stage::tell.
  /// @throws as Application::Perform, after the session has ended.
  [[nodiscard]] const TaskResult& Execute(const run::RunHooks& hooks,
                                          const std::function<void(std::string_view)>& tell = {});
  /// @param evidence  without the session's result, which is added. @pre Execute() has returned.
  [[nodiscard]] Evaluation Evaluate(Evidence evidence);
  /// @pre Execute() has returned.
  [[nodiscard]] const run::SessionResult& result() const noexcept { return result_; }

 private:
  const scenario::Scenario scenario_;
  const run::RunFiles files_;
  const Clock& clock_;
  const teleop::DeviceRegistry* devices_;
  std::unique_ptr<Application> application_;
  run::Session session_;
  TaskResult task_result_;
  run::SessionResult result_;
};

}  // namespace twin::application
