#pragma once

#include <functional>
#include <memory>
#include <string_view>

#include "twin/application/application.h"
#include "twin/backend/registry.h"
#include "twin/core/clock.h"
#include "twin/rt/cycle_record.h"
#include "twin/run/run.h"
#include "twin/run/session.h"
#include "twin/scenario/robot_data.h"
#include "twin/scenario/scenario.h"

namespace twin::application {

/// An application's scenario made ready: its robot connected on its drive, the application with its
/// parameters.
///
///     construct -> [CheckStart] -> Execute -> Evaluate
///
/// Threads: one thread.
class ApplicationRun {
 public:
  /// @param sink, settings  as run::Run's. @param clock  wall clock, for what planning takes.
  /// All references must outlive this.
  /// @throws InputError when the scenario names no application or an unknown one, and as
  /// scenario::Session.
  ApplicationRun(const scenario::Scenario& scenario, const run::Catalogue& catalogue,
                 const run::RunFiles& files, rt::RecordSink* sink, const Clock& clock,
                 const run::RealtimeSettings& settings = {});

  [[nodiscard]] const backend::Connection& connection() const noexcept;
  [[nodiscard]] const scenario::RobotData& robot() const noexcept;
  /// As Application's.
  [[nodiscard]] Duration longest() const;

  /// As run::Run::CheckStart.
  [[nodiscard]] bool CheckStart(const run::TellCheck& tell);

  /// From the session's begin to its end. Once. @param tell  gets lines for people; may be empty.
  /// @throws as Application::Perform; the session has ended all the same.
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
