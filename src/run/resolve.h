#pragma once

#include <optional>

#include "twin/core/modes.h"
#include "twin/loop/loop_config.h"
#include "twin/planning/planner.h"
#include "twin/plant/mujoco_plant.h"
#include "twin/reference/trajectory.h"
#include "twin/robot/robot_config.h"
#include "twin/run/run.h"
#include "twin/run/session.h"
#include "twin/scenario/robot_data.h"
#include "twin/scenario/scenario.h"

namespace twin::run {

/// The robot a scenario comes to, short of a compiled model.
struct RobotPlan {
  scenario::RobotData robot;
  robot::RobotConfig config;
};

/// What a scenario comes to, short of a compiled model: each part made once and checked.
struct Plan {
  scenario::RobotData robot;
  robot::RobotConfig config;
  Motion motion;
  std::optional<planning::PlanStatistics> planning;  ///< of a planned motion
};

/// @throws NoPlanError when no motion was found within the plan's budget; InputError naming what
/// is wrong and, where the scenario was read from a file, its line.
[[nodiscard]] Plan MakePlan(const scenario::Scenario& scenario, const Catalogue& catalogue,
                            const RunFiles& files);

/// As MakePlan, of the robot only.
[[nodiscard]] RobotPlan MakeRobotPlan(const scenario::Scenario& scenario,
                                      const Catalogue& catalogue, const RunFiles& files);

/// Plans the scenario's motion. The same scenario, robot and start give the same one to the bit,
/// whatever the seed of the plant's options. A random goal is drawn as from robot.q_start.
/// @param start       where the arm stands, rad.
/// @param statistics  filled in.
/// @pre scenario.motion.plan and scenario.robot.q_start are there.
/// @throws InputError when start or goal touches something (names the bodies), the goal is out of
/// reach, or a value is out of range; NoPlanError when no path was found within the budget.
[[nodiscard]] reference::Trajectory PlanMotion(const scenario::Scenario& scenario,
                                               const scenario::RobotData& robot,
                                               const JointVector& start, const RunFiles& files,
                                               planning::PlanStatistics& statistics);

/// Refuses a motion that leaves the scenario's limits: regions and caps on speed, in every cycle;
/// of poses, those of end effector and hand. @throws model::LimitBreach
void RequireWithinLimits(const scenario::Scenario& scenario, const scenario::RobotData& robot,
                         const Motion& motion);

/// Refuses a motion of joints that is too fast for a robot whose velocity limit shrinks towards the
/// ends of its range, in any cycle. @throws InputError
void RequireVelocitiesByPosition(const JointLimits& limits, const Motion& motion);

/// Factor, 1 or more, on the time of the scenario's motion along joint positions. Commanded as
/// poses it brings the end effector's speed, acceleration and jerk to the motion's shares of its
/// limits, by differences of the poses in successive cycles.
[[nodiscard]] double EndEffectorStretch(const scenario::Scenario& scenario,
                                        const scenario::RobotData& robot,
                                        const reference::Trajectory& trajectory);

/// Refuses a motion of joints on the pose interface that takes the end effector beyond its limits,
/// by the same differences. @throws InputError
void RequireEndEffectorWithinLimits(const CartesianLimits& limits, const Transform& F_T_EE,
                                    const Motion& motion);

/// Refuses a robot that stands outside the scenario's regions. @throws model::LimitBreach
void RequireStartWithinLimits(const scenario::Scenario& scenario, const scenario::RobotData& robot,
                              const JointVector& q);

// Parts of a plan.

/// The scenario's own motion along its trajectory. @throws InputError as MakePoses.
[[nodiscard]] Motion MotionOf(const scenario::Scenario& scenario, const scenario::RobotData& robot,
                              reference::Trajectory trajectory);

/// Torques go with the joint velocity generator, whose commands stay 0. Source: FCI protocol 5,
/// what a client library does for a torque loop.
[[nodiscard]] MotionModes ModesOf(const scenario::MotionSection& motion);

/// True when the client library or INT smooths the commands of motions, so that a generator's steps
/// arrive weakened.
[[nodiscard]] bool HasLowPass(const scenario::Scenario& scenario);

/// @throws InputError as TickConfig::Validate; when the generator is rejoining and HasLowPass().
[[nodiscard]] loop::TickConfig MakeTick(const scenario::Scenario& scenario,
                                        const scenario::RobotData& robot);

/// @throws InputError as ControllerLoopConfig::Validate.
[[nodiscard]] loop::ControllerLoopConfig MakeControllerLoop(
    const scenario::ControllerSection& controller);

}  // namespace twin::run
