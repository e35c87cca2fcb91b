#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "twin/application/evidence.h"
#include "twin/application/task.h"
#include "twin/control/controller.h"
#include "twin/core/joint_vector.h"
#include "twin/core/time.h"
#include "twin/report/plot.h"
#include "twin/scenario/scenario.h"

namespace twin::application {

class Stage;

/// A motion that was planned and then carried out, for a pair of pictures: before it, with its goal
/// as a ghost and its way as a line; and after it.
struct Snapshot {
  std::string id;       ///< letters, digits, '_'; names the files
  std::string caption;  ///< one sentence
  Time planned{};       ///< of the session
  Time done{};
  std::optional<JointVector> goal{};          ///< of the arm, rad; absent: where it stands
  std::vector<Vector3> way{};                 ///< of the end effector, base frame, m
  std::string object{};                       ///< body that is carried there; empty: none
  Transform O_T_object = kIdentityTransform;  ///< where its goal is
};

/// A figure that tells how well it went.
struct Finding {
  std::string quantity;
  double value = 0;
  std::string unit{};
  std::string demand{};       ///< in words: "at most 5 mm"; empty: none
  std::optional<bool> met{};  ///< absent: nothing is demanded
};

/// What was done.
struct TaskResult {
  TaskReport task;
  std::vector<Snapshot> snapshots{};
  Duration planning_time{};  ///< on the wall clock; repeats by none but a virtual one
};

/// What an application makes of the evidence.
struct Evaluation {
  std::vector<Finding> findings{};
  std::vector<report::Figure> figures{};  ///< drawn by templates/application/ID.gp
};

/// Does a whole task on a robot, by motions and commands to the hand, whatever drive the robot is
/// on; then judges what came of it.
///
/// Threads: one thread. Not for real-time code.
class Application {
 public:
  virtual ~Application() = default;

  /// Looks whether a scenario has what it takes, before anything is connected.
  /// @throws InputError naming what is missing, with file and line.
  virtual void Require(const scenario::Scenario& /*scenario*/) const {}
  /// Whether it is at home on a mobile base, where O moves; the others are refused beside one.
  [[nodiscard]] virtual bool drives_base() const noexcept { return false; }

  /// Interface of the motion that comes first: what a robot must grant before anything moves.
  [[nodiscard]] virtual control::CommandInterface first_interface() const noexcept = 0;
  /// Longer than it takes on a scenario, in the robot's time; what comes later is not filmed.
  [[nodiscard]] virtual Duration longest(const scenario::Scenario& scenario) const = 0;

  /// @throws InputError for what the scenario asks and cannot be; RobotFault outside steps.
  [[nodiscard]] virtual TaskResult Perform(Stage& stage) = 0;

  /// Called once, when the session has ended, whether or not it went well.
  [[nodiscard]] virtual Evaluation Evaluate(const TaskResult& task_result,
                                            const Evidence& evidence) = 0;
};

/// The application a scenario names, with its parameters.
/// @pre scenario.application. @throws InputError when it is unknown, or a parameter is not as it
/// should be; naming file and line.
[[nodiscard]] std::unique_ptr<Application> Make(const scenario::Scenario& scenario);

/// Names of all, in order.
[[nodiscard]] std::vector<std::string> Names();

}  // namespace twin::application
