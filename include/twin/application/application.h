#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "twin/application/partners.h"
#include "twin/core/clock.h"
#include "twin/core/joint_vector.h"
#include "twin/core/time.h"
#include "twin/planning/collision_world.h"
#include "twin/plant/contact_watch.h"
#include "twin/record/log_records.h"
#include "twin/reference/trajectory.h"
#include "twin/report/plot.h"
#include "twin/run/run.h"
#include "twin/run/session.h"
#include "twin/scenario/scenario.h"
#include "twin/teleop/device_registry.h"

namespace twin::application {

/// Records of a finished run, ground truth included: for Application::Evaluate, never for Perform.
struct Evidence {
  std::filesystem::path log;                      ///< empty: none
  const plant::ContactWatch* contacts = nullptr;  ///< null: this process simulates nothing
  run::SessionResult session{};
  std::string prefix{};  ///< of the names of the robot's bodies, as TruthProbe::prefix()

  /// The motion of a body; nullopt when it is not simulated or not watched.
  [[nodiscard]] std::optional<plant::ObjectTrack> TrackOf(std::string_view body) const;
};

/// A quantity measured over a run.
struct Finding {
  std::string quantity;
  double value = 0;
  std::string unit{};
  std::string demand{};       ///< in words: "at most 5 mm"; empty: none
  std::optional<bool> met{};  ///< nullopt: nothing is demanded
};

/// A value as users read it: at most four significant digits, and none below what its unit means
/// here (micrometres, 0.01 mm/s, 0.001 degrees, 10 ms): "0.18" mm, "0.00" mm/s, "36.1" s.
[[nodiscard]] std::string RoundedText(double value, std::string_view unit);

/// An application's judgement of the evidence.
struct Evaluation {
  std::vector<Finding> findings{};
  std::vector<report::Figure> figures{};  ///< drawn by templates/application/ID.gp

  /// Adds a quantity without a demand.
  void Add(std::string quantity, double value, std::string unit = {});
  void Demand(std::string quantity, double value, std::string unit, std::string demand, bool met);
  /// Demands value <= most; a `most` of 0 reads "none"; nullopt demands nothing.
  void DemandAtMost(std::string quantity, double value, std::string unit,
                    std::optional<double> most);
  /// Demands an empty list; its elements are appended to the quantity.
  void DemandNone(std::string quantity, const std::vector<std::string>& list);
};

/// How one attempt at a step ended.
struct StepEnd {
  bool succeeded = true;
  std::string text{};  ///< why not, or a remark for the report
};

/// A step of a task: a state of its machine.
struct TaskStep {
  std::string name;                ///< unique within the task
  std::function<StepEnd()> act{};  ///< one attempt
  /// Step at which the task continues after a failure: this or an earlier one. Empty: the failure
  /// ends the task.
  std::string after_failure{};
  int attempts = 1;  ///< in all, >= 1; the failure of the last one ends the task
};

/// One attempt at a step.
struct StepReport {
  std::string name;
  int attempt = 1;  ///< counted from 1
  Time begun{};
  Time ended{};
  bool succeeded = false;
  std::string text{};  ///< as StepEnd's
};

struct TaskReport {
  std::vector<StepReport> steps;  ///< all attempts, in order of execution
  std::string failure;            ///< failed step and cause; empty: the task succeeded
};

/// Executes steps, each after the success of the previous one. After a failed attempt, the task
/// continues at the step's `after_failure` while the failed step has attempts left. Attempts are
/// counted over the whole task, so the task ends.
///
/// A step that throws RobotFault has failed with its text and is not repeated, because the robot
/// refuses commands or does not answer. Other exceptions propagate.
/// @param now  the robot's time. @param on_attempt  receives each finished attempt; may be empty.
/// @param interrupted  called before each attempt; true ends the task; may be empty.
/// @throws InputError if two steps have the same name, attempts are below 1, or `after_failure` is
/// neither the step itself nor an earlier one.
[[nodiscard]] TaskReport Carry(const std::vector<TaskStep>& steps, const std::function<Time()>& now,
                               const std::function<void(const StepReport&)>& on_attempt = {},
                               const std::function<bool()>& interrupted = {});

/// A performed task.
struct TaskResult {
  TaskReport task;
  std::vector<record::PlanRecord> plans{};  ///< motions that the report shows in pairs of pictures
  Duration planning_time{};                 ///< on the wall clock, so it does not repeat
  std::vector<std::string> robot_errors{};  ///< errors that ended motions
  std::string lost_recording{};  ///< why the operator's input was not recorded; empty: as asked for
};

/// The failed step, else the first missed demand; empty if the task succeeded and every demand is
/// met.
[[nodiscard]] std::string FailureOf(const TaskResult& task_result, const Evaluation& evaluation);

/// One sentence: how many demands are met and which quantities were demanded, or which demands are
/// missed; empty without demands.
[[nodiscard]] std::string VerdictOf(const Evaluation& evaluation);

/// The robot and the world that an application works with. All references must outlive it.
///
/// Threads: one thread.
struct Stage {
  run::Session& session;
  const scenario::Scenario& scenario;
  const run::RunFiles& files;
  const Clock& clock;  ///< wall clock, only to measure how long planning takes
  const teleop::DeviceRegistry* devices = nullptr;  ///< of operators; null: there are none
  const Partners* partners = nullptr;               ///< other robots; null: the robot is alone
  std::function<void(std::string_view)> tell{};  ///< receives one log line per event; may be empty
  TaskResult result{};                           ///< of the task, filled by the application

  /// End effector in the flange, as configured in the robot.
  [[nodiscard]] Transform F_T_EE() const;
  /// A world to plan in: the scenario's scene and robot; of several robots the others, too, where
  /// they start (CollisionWorld::PlaceArm, by their indices in Partners::robots()).
  /// @throws as planning::CollisionWorld.
  [[nodiscard]] std::unique_ptr<planning::CollisionWorld> MakeWorld() const;
  /// Runs application::Carry() on the session's time, into `result`; reports each attempt to `tell`
  /// and the log.
  void Carry(const std::vector<TaskStep>& steps);
  /// Moves, and names an error of the robot in `result`. @throws as run::Session::Move.
  [[nodiscard]] run::MotionResult Move(const run::Motion& motion);
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
  /// Checks the robots beside its own. @param partners  null: the robot is alone.
  /// @throws InputError, as Require().
  virtual void RequirePartners(const scenario::Scenario& /*scenario*/,
                               const Partners* /*partners*/) const {}
  /// Upper bound of the duration, robot's time; the video ends there.
  [[nodiscard]] virtual Duration longest(const scenario::Scenario& scenario) const = 0;

  /// Fills stage.result.
  /// @throws InputError for a scenario that cannot be carried out; RobotFault outside of steps.
  virtual void Perform(Stage& stage) = 0;

  /// Called once, after the session has ended, also after a failure.
  [[nodiscard]] virtual Evaluation Evaluate(const TaskResult& task_result,
                                            const Evidence& evidence) = 0;
};

/// The application that a scenario names, with its parameters. @pre scenario.application.
/// @param partners  as Stage's. @throws InputError for an unknown name or an invalid parameter,
/// with file and line.
[[nodiscard]] std::unique_ptr<Application> Make(const scenario::Scenario& scenario,
                                                const Partners* partners = nullptr);

/// Path of the end effector for a picture, base frame, m: its first point, then each at least 2 cm
/// from the last; wider apart where they exceed render::Ghost::kMostPoints. Threads: any.
/// @param q  joint positions along the path, rad, not empty. @param F_T_EE  end effector in the
/// flange.
[[nodiscard]] std::vector<Vector3> EndEffectorPath(const std::vector<JointVector>& q,
                                                   const Transform& F_T_EE);
[[nodiscard]] std::vector<Vector3> EndEffectorPath(const reference::Trajectory& trajectory,
                                                   const Transform& F_T_EE);

/// An application on its robot: construct -> [CheckStart] -> Execute -> Evaluate.
///
/// Threads: one thread.
class ApplicationRun {
 public:
  /// Connects the robot. @param sink, settings  as run::Run's. @param clock, partners  as Stage's.
  /// All references must outlive this.
  /// @throws InputError for a scenario without an application, and as Make() and run::Session.
  ApplicationRun(const scenario::Scenario& scenario, const run::Catalogue& catalogue,
                 const run::RunFiles& files, record::RecordSink* sink, const Clock& clock,
                 const run::RealtimeConfig& settings = {}, const Partners* partners = nullptr);

  [[nodiscard]] const backend::Connection& connection() const { return session_.connection(); }
  [[nodiscard]] const scenario::RobotData& robot() const { return session_.robot(); }
  /// As Application's.
  [[nodiscard]] Duration longest() const { return application_->longest(scenario_); }
  /// As run::Run::CheckStart.
  [[nodiscard]] bool CheckStart(const run::TellCheck& tell);

  /// The whole session, once. @param tell  as Stage::tell.
  /// @throws as Application::Perform, after the session has ended.
  const TaskResult& Execute(const run::RunHooks& hooks,
                            const std::function<void(std::string_view)>& tell = {});
  /// @param evidence  without the session's result, which is added. @pre Execute() has returned.
  const Evaluation& Evaluate(Evidence evidence);

  [[nodiscard]] const TaskResult& task_result() const noexcept { return stage_.result; }
  [[nodiscard]] const run::SessionResult& session_result() const noexcept { return result_; }
  /// Without findings before Evaluate().
  [[nodiscard]] const Evaluation& evaluation() const noexcept { return evaluation_; }

 private:
  const scenario::Scenario scenario_;
  const run::RunFiles files_;
  std::unique_ptr<Application> application_;
  run::Session session_;
  Stage stage_;
  run::SessionResult result_;
  Evaluation evaluation_;
};

}  // namespace twin::application
