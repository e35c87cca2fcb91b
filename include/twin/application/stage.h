#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "twin/application/task.h"
#include "twin/core/clock.h"
#include "twin/core/joint_vector.h"
#include "twin/planning/collision_world.h"
#include "twin/run/run.h"
#include "twin/run/session.h"
#include "twin/scenario/robot_data.h"
#include "twin/scenario/scenario.h"
#include "twin/teleop/device_registry.h"

namespace twin::application {

/// What an application works with: a robot on which motions follow each other, and what is known of
/// it and of the world around it.
///
/// Threads: one thread.
class Stage {
 public:
  /// @param tell  gets a line for people about what is done; may be empty. All references must
  /// outlive the stage.
  Stage(run::Session& session, const scenario::Scenario& scenario, const run::RunFiles& files,
        const Clock& clock, std::function<void(std::string_view)> tell = {},
        const teleop::DeviceRegistry* devices = nullptr);

  [[nodiscard]] run::Session& session() const noexcept { return session_; }
  [[nodiscard]] const scenario::Scenario& scenario() const noexcept { return scenario_; }
  [[nodiscard]] const scenario::RobotData& robot() const noexcept { return session_.robot(); }
  /// Wall clock, for what planning takes; nothing else may depend on it.
  [[nodiscard]] const Clock& clock() const noexcept { return clock_; }
  /// End effector in the flange, as the robot is told.
  [[nodiscard]] const Transform& F_T_EE() const noexcept { return F_T_EE_; }

  /// The world to plan in, made when first asked for: scene and robot as the scenario has them.
  /// @throws as planning::CollisionWorld.
  [[nodiscard]] planning::CollisionWorld& World();

  /// What an operator may lead by; null: nothing.
  [[nodiscard]] const teleop::DeviceRegistry* devices() const noexcept { return devices_; }

  /// A motion on this interface, its loop, tick and controller's timing the scenario's, its
  /// generator the interface's. What it follows, and the controller's type and parameters, are the
  /// caller's to add.
  [[nodiscard]] run::Motion NewMotion(std::string name, control::CommandInterface interface,
                                      reference::Trajectory trajectory) const;

  /// Carries out steps on the session's time; each attempt is told and is an event of the log.
  [[nodiscard]] TaskReport Carry(const std::vector<TaskStep>& steps) const;

  void Tell(std::string_view line) const {
    if (tell_) tell_(line);
  }

 private:
  run::Session& session_;
  const scenario::Scenario& scenario_;
  const run::RunFiles& files_;
  const Clock& clock_;
  std::function<void(std::string_view)> tell_;
  const teleop::DeviceRegistry* devices_;
  Transform F_T_EE_;
  std::unique_ptr<planning::CollisionWorld> world_;
};

}  // namespace twin::application
