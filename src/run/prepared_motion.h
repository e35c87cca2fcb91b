#pragma once

#include <memory>
#include <optional>

#include "run/resolve.h"
#include "twin/control/controller.h"
#include "twin/control/registry.h"
#include "twin/loop/motion_run.h"
#include "twin/run/run.h"
#include "twin/run/session.h"

namespace twin::run {

/// A motion short of being run: its controller with its parameters, the set-up of its loops.
///
/// Threads: one thread.
class PreparedMotion {
 public:
  /// @param scenario  whose sections motion, controller, tick and loop are the motion's: see As().
  /// @throws InputError when the controller is unknown, commands another interface or refuses a
  /// parameter, and for what the loops find wrong; as RequireVelocitiesByPosition and, a
  /// model::LimitBreach, RequireWithinLimits.
  PreparedMotion(const scenario::Scenario& scenario, const scenario::RobotData& robot,
                 Motion motion, const control::ControllerRegistry& known);
  PreparedMotion(const PreparedMotion&) = delete;
  PreparedMotion& operator=(const PreparedMotion&) = delete;

  [[nodiscard]] const Motion& motion() const noexcept { return motion_; }

  /// @returns the run it asks for, without sink and hooks, of that seed.
  [[nodiscard]] loop::MotionRun Run(backend::Backend& backend, std::uint64_t seed);

  /// How far from the goal pose the arm is at `q`; nothing of a motion that has none.
  [[nodiscard]] std::optional<PoseError> PoseErrorAt(const JointVector& q) const;

 private:
  const Motion motion_;
  const Transform F_T_EE_;  ///< as the robot is told
  const MotionModes modes_;
  const loop::TickConfig tick_;
  const loop::ControllerLoopConfig controller_loop_;
  std::unique_ptr<control::Controller> controller_;  ///< refers to motion_
};

/// @returns the scenario with the motion's sections in place of its own, validated.
/// @throws InputError naming the field that is out of range.
[[nodiscard]] scenario::Scenario As(const scenario::Scenario& scenario, const Motion& motion);

}  // namespace twin::run
