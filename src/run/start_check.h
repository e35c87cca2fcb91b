#pragma once

#include <string>
#include <vector>

#include "twin/backend/backend.h"
#include "twin/core/clock.h"
#include "twin/core/joint_vector.h"
#include "twin/core/robot_state.h"
#include "twin/core/setting.h"
#include "twin/loop/robot_listener.h"
#include "twin/rt/signal.h"
#include "twin/run/remote.h"
#include "twin/scenario/robot_data.h"
#include "twin/scenario/scenario.h"

// What must hold before a robot at the other end of a wire is moved for the first time. Each check
// is a function of what was found; nothing of it moves the arm.
namespace twin::run {

/// How far from its limits a joint must be, rad: about a degree, more than an arm swings on when it
/// is stopped at low speed.
inline constexpr double kLimitMargin = 0.02;

/// How far from robot.q_start an arm may stand for which a motion is planned, rad: what people who
/// guide it there can do. The plan starts where it stands.
inline constexpr double kPlanStartTolerance = 0.02;

/// How far a torque at rest may be from that of the arm as it is described, Nm: what friction
/// holds, and more than the model of a real arm is wrong by. Half a kilogram at the flange or 4
/// degrees of tilt in the ready pose are more.
inline constexpr double kRestTolerance = 1.5;

/// Share of the states a loop must be able to answer. libfranka's own communication test calls a
/// setup insufficient below it.
inline constexpr double kLeastSuccessRate = 0.9;

[[nodiscard]] CheckLine CheckStates(const loop::ListenReport& heard, backend::RobotTime time);
[[nodiscard]] CheckLine CheckMode(const RobotState& state);
[[nodiscard]] CheckLine CheckErrors(const RobotState& state);
[[nodiscard]] CheckLine CheckLimits(const RobotState& state, const JointLimits& limits);
/// What the robot says it carries, against what the scenario says it was told.
[[nodiscard]] CheckLine CheckPayload(const RobotState& state, const scenario::Scenario& scenario,
                                     const scenario::RobotData& robot);
/// The torques that hold the arm at rest, against those of links (plant.mass_scale), hand, base
/// tilt (plant.base_tilt) and load (robot.load), which a lab file may say: g(q) of model::ArmModel.
/// A robot without torque sensors, all of whose torques are 0, is not judged.
[[nodiscard]] CheckLine CheckTorques(const RobotState& state, const scenario::Scenario& scenario,
                                     const scenario::RobotData& robot);
/// @param start  the trajectory's first point, rad; of a planned one that was not planned from
/// where the robot stands, robot.q_start.
[[nodiscard]] CheckLine CheckStart(const RobotState& state, const scenario::Scenario& scenario,
                                   const JointVector& start);
[[nodiscard]] CheckLine CheckCommunication(const loop::ListenReport& heard,
                                           const loop::ListenSettings& settings,
                                           backend::RobotTime time);
[[nodiscard]] CheckLine CheckScheduler(const std::vector<std::string>& notices,
                                       backend::RobotTime time);

/// The requests that make the robot what the scenario's section onboard says.
/// @param has_filters  the robot knows the request for them.
[[nodiscard]] std::vector<Setting> SettingsOf(const scenario::OnboardSection& onboard,
                                              bool has_filters);

/// The robot, and how to listen to it.
struct StartCheck {
  const MonotonicClock& clock;
  backend::Backend& backend;
  rt::Arrival& arrival;
  backend::RobotTime time = backend::RobotTime::kWall;
  loop::ListenSettings listening;
};

/// Listens, checks, sends the settings, listens again, checks; tells each line as soon as it is
/// known. @returns whether all are ok.
[[nodiscard]] bool RunStartCheck(const StartCheck& check, const scenario::Scenario& scenario,
                                 const scenario::RobotData& robot, const JointVector& start,
                                 const TellCheck& tell);

}  // namespace twin::run
