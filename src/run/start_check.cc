#include "run/start_check.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string_view>

#include <fmt/format.h>

#include "twin/core/error.h"
#include "twin/fci/protocol.h"
#include "twin/model/arm_model.h"
#include "twin/reference/trajectory.h"

namespace twin::run {
namespace {

/// A torque controller takes in more than a reference does.
constexpr double kTorqueStartTolerance = 0.02;
/// Settings have been taken by then.
constexpr Duration kShortly = std::chrono::milliseconds(20);

std::string_view WayOutOf(RobotMode mode) {
  switch (mode) {
    case RobotMode::kOther: return "open the brakes in Desk, and activate FCI";
    case RobotMode::kMove: return "another program moves it: end that motion first";
    case RobotMode::kGuiding: return "let go of the guiding button";
    case RobotMode::kReflex:
      return "see why it stopped and remove the cause; then recover it (automatic error recovery, "
             "or press and release the user stop)";
    case RobotMode::kUserStopped: return "release the user stop";
    case RobotMode::kAutomaticErrorRecovery: return "wait until it has recovered";
    case RobotMode::kIdle: break;
  }
  return "";
}

/// The joint whose `distance` is the largest, or no number.
template <typename Distance>
std::size_t WorstJoint(Distance distance) {
  std::size_t worst = 0;
  for (std::size_t i = 0; i < kJoints; ++i) {
    if (std::isnan(distance(i))) return i;
    if (distance(i) > distance(worst)) worst = i;
  }
  return worst;
}

/// Gravity in the axes of a tilted base, m/s^2: plant::BaseTilt.
Vector3 TiltedGravity(const plant::BaseTilt& tilt) {
  constexpr double kG = 9.81;
  return {kG * std::sin(tilt.pitch), -kG * std::cos(tilt.pitch) * std::sin(tilt.roll),
          -kG * std::cos(tilt.pitch) * std::cos(tilt.roll)};
}

/// What holds the arm that the scenario describes, Nm.
JointVector HoldingTorques(const JointVector& q, const scenario::Scenario& scenario,
                           const scenario::RobotData& robot) {
  const model::ArmModel& arm = robot.arm;
  const Vector3 gravity = TiltedGravity(scenario.plant.base_tilt);
  const setting::Load& load = scenario.robot.load;
  const auto hold = [&](const model::Payload& payload) { return arm.Gravity(q, payload, gravity); };
  const JointVector arm_and_hand = hold(robot.end_effector);
  const JointVector alone = hold({});
  const JointVector loaded = hold({load.m_load, load.F_x_Cload, load.I_load});
  JointVector torques{};
  for (std::size_t i = 0; i < kJoints; ++i) {
    torques[i] = scenario.plant.mass_scale * arm_and_hand[i] + loaded[i] - alone[i];
  }
  return torques;
}

CheckLine SendSettings(backend::Backend& backend, const std::vector<Setting>& settings) {
  try {
    for (const Setting& setting : settings) backend.Configure(setting);
  } catch (const Error& error) {
    return {"settings", false, error.what()};
  }
  return {"settings", true, fmt::format("{} sent (section onboard)", settings.size())};
}

}  // namespace

CheckLine CheckStates(const loop::ListenReport& heard, backend::RobotTime time) {
  const std::string found =
      fmt::format("{} read at {:.1f} Hz, {} lost", heard.states, heard.rate_hz, heard.lost);
  if (heard.states < 2) {
    return {"states", false,
            fmt::format("{}; does a firewall stop UDP from the robot to this machine?", found)};
  }
  constexpr double kSlightlyOff = 0.05;
  // A robot whose states are the time may be as slow as its host.
  if (time == backend::RobotTime::kWall && std::abs(heard.rate_hz / 1000 - 1) > kSlightlyOff) {
    return {"states", false,
            fmt::format("{}; the robot's cycle is 1000 Hz: is it a twin on a machine that does not "
                        "keep up, or one that is served in lockstep (--robot-time states)?",
                        found)};
  }
  return {"states", true, found};
}

CheckLine CheckMode(const RobotState& state) {
  if (state.robot_mode == RobotMode::kIdle) return {"mode", true, "Idle"};
  return {"mode", false,
          fmt::format("{}, not Idle; {}", Name(state.robot_mode), WayOutOf(state.robot_mode))};
}

CheckLine CheckErrors(const RobotState& state) {
  if (state.errors.none()) return {"errors", true, "none"};
  return {
      "errors", false,
      fmt::format("{}; remove their cause, then recover the robot", FormatErrors(state.errors))};
}

CheckLine CheckLimits(const RobotState& state, const JointLimits& limits) {
  const auto beyond = [&](std::size_t i) {
    return std::max(limits.q_min[i] + kLimitMargin - state.q[i],
                    state.q[i] - (limits.q_max[i] - kLimitMargin));
  };
  const std::size_t worst = WorstJoint(beyond);
  if (std::isfinite(state.q[worst]) && beyond(worst) <= 0) {
    return {"joint limits", true,
            fmt::format("every joint is at least {:.3f} rad from its limits",
                        kLimitMargin - beyond(worst))};
  }
  return {"joint limits", false,
          fmt::format("joint {} is at {:.4f} rad; it must lie in [{:.4f}, {:.4f}], {} rad inside "
                      "its limits: guide the arm away from them",
                      worst + 1, state.q[worst], limits.q_min[worst] + kLimitMargin,
                      limits.q_max[worst] - kLimitMargin, kLimitMargin)};
}

CheckLine CheckPayload(const RobotState& state, const scenario::Scenario& scenario,
                       const scenario::RobotData& robot) {
  constexpr double kSame = 1e-3;  // kg, m
  const double m_ee = robot.end_effector.m;
  if (!(std::abs(state.m_ee - m_ee) <= kSame)) {
    return {"payload", false,
            fmt::format("the robot reckons with an end effector of {:.3f} kg, the scenario with "
                        "{:.3f} kg (robot.hand); set the end effector in Desk, or say which one is "
                        "mounted in the scenario",
                        state.m_ee, m_ee)};
  }
  const setting::Load& load = scenario.onboard.load;
  double off = std::abs(state.m_load - load.m_load);
  for (std::size_t i = 0; i < 3; ++i) {
    off = std::max(off, std::abs(state.F_x_Cload[i] - load.F_x_Cload[i]));
  }
  if (!(off <= kSame)) {
    return {
        "payload", false,
        fmt::format("the robot reckons with a load of {:.3f} kg, the scenario told it {:.3f} kg "
                    "(onboard.load); did another program set it?",
                    state.m_load, load.m_load)};
  }
  return {"payload", true,
          fmt::format("end effector {:.3f} kg, load {:.3f} kg", state.m_ee, state.m_load)};
}

CheckLine CheckTorques(const RobotState& state, const scenario::Scenario& scenario,
                       const scenario::RobotData& robot) {
  if (state.tau_J == JointVector{}) {
    return {"torques", true, "not compared: this robot measures none"};
  }
  const JointVector expected = HoldingTorques(state.q, scenario, robot);
  const auto off = [&](std::size_t i) { return std::abs(state.tau_J[i] - expected[i]); };
  const std::size_t worst = WorstJoint(off);
  constexpr double kDegrees = 180 / std::numbers::pi;
  const plant::BaseTilt& tilt = scenario.plant.base_tilt;
  const std::string described =
      fmt::format("a base tilted by {:.1f}, {:.1f} deg (roll, pitch) and a load of {:.3f} kg",
                  tilt.roll * kDegrees, tilt.pitch * kDegrees, scenario.robot.load.m_load);
  if (off(worst) <= kRestTolerance) {
    return {
        "torques", true,
        fmt::format("at rest within {:.2f} Nm of {} (joint {})", off(worst), described, worst + 1)};
  }
  return {"torques", false,
          fmt::format("joint {} holds {:.2f} Nm at rest, and {} need {:.2f} Nm; {} Nm are allowed: "
                      "measure tilt and load, and say them (plant.base_tilt, robot.load; load in a "
                      "lab file), or free the arm of what it touches",
                      worst + 1, state.tau_J[worst], described, expected[worst], kRestTolerance)};
}

CheckLine CheckStart(const RobotState& state, const scenario::Scenario& scenario,
                     const JointVector& start) {
  const bool by_torque = scenario.motion.interface == control::CommandInterface::kTorque;
  const bool is_planned = scenario.motion.plan.has_value();
  const JointVector& q = by_torque ? state.q : state.q_d;
  const double tolerance = by_torque ? kTorqueStartTolerance : reference::kStartTolerance;
  const std::string_view point = is_planned ? "the plan's start" : "the first waypoint";
  const auto distance = [&](std::size_t i) { return std::abs(q[i] - start[i]); };
  const std::size_t worst = WorstJoint(distance);
  if (distance(worst) <= tolerance) {
    return {"start", true,
            fmt::format("{:.1e} rad from {} (joint {})", distance(worst), point, worst + 1)};
  }
  const std::string cure =
      is_planned
          ? fmt::format(
                "bring the arm within {} rad of robot.q_start: the plan then starts where "
                "it stands",
                kPlanStartTolerance)
          : "bring the arm there (panda-twin move-to start-of FILE), or let this one start where "
            "the arm is";
  return {"start", false,
          fmt::format("joint {} is {:.4f} rad from {}: it is at {:.4f} rad, the motion starts at "
                      "{:.4f} rad, and {} rad are allowed; {}",
                      worst + 1, distance(worst), point, q[worst], start[worst], tolerance, cure)};
}

CheckLine CheckCommunication(const loop::ListenReport& heard, const loop::ListenSettings& settings,
                             backend::RobotTime time) {
  const std::string found = fmt::format(
      "success rate {:.3f}; states off their millisecond by {:.0f} / {:.0f} / {:.0f} us (median, "
      "p99, max)",
      heard.success_rate(), ToMicroseconds(heard.deviation.Percentile(0.5)),
      ToMicroseconds(heard.deviation.Percentile(0.99)), ToMicroseconds(heard.deviation.max()));
  // A robot that waits for its answers has no cycle to miss.
  if (time == backend::RobotTime::kStates || heard.success_rate() >= kLeastSuccessRate) {
    return {"communication", true, found};
  }
  return {"communication", false,
          fmt::format("{}; at least {} must come within {:.0f} us: connect the robot by its own "
                      "cable, give the thread a processor of its own (--ext-cpu), and see "
                      "panda-twin check",
                      found, kLeastSuccessRate, ToMicroseconds(settings.tolerance))};
}

CheckLine CheckScheduler(const std::vector<std::string>& notices, backend::RobotTime time) {
  if (notices.empty()) return {"scheduler", true, "real-time priority and memory lock granted"};
  if (time == backend::RobotTime::kStates) {
    return {"scheduler", true, "no real-time rights, and none are needed"};
  }
  return {"scheduler", false, fmt::format("{}", fmt::join(notices, "; "))};
}

std::vector<Setting> SettingsOf(const scenario::OnboardSection& onboard, bool has_filters) {
  std::vector<Setting> settings{setting::JointImpedance{onboard.K_theta},
                                setting::CartesianImpedance{onboard.K_x},
                                onboard.collision_behavior,
                                onboard.guiding_mode,
                                setting::StiffnessFrame{onboard.EE_T_K.Matrix()},
                                setting::EndEffectorFrame{onboard.NE_T_EE.Matrix()},
                                onboard.load};
  if (has_filters) settings.emplace_back(onboard.filters);
  return settings;
}

bool RunStartCheck(const StartCheck& check, const scenario::Scenario& scenario,
                   const scenario::RobotData& robot, const JointVector& start,
                   const TellCheck& tell) {
  bool all_ok = true;
  const auto note = [&](const CheckLine& line) {
    all_ok = all_ok && line.ok;
    if (tell) tell(line);
    return line.ok;
  };
  const auto listen = [&check](Duration span) {
    loop::ListenSettings settings = check.listening;
    settings.span = span;
    return loop::ListenToRobot(check.clock, check.backend, check.arrival, settings);
  };
  const loop::ListenReport heard = listen(check.listening.span);
  note(CheckStates(heard, check.time));
  if (heard.states == 0) return false;
  const bool is_idle = note(CheckMode(heard.last));
  note(CheckErrors(heard.last));
  note(CheckLimits(heard.last, robot.limits));
  RobotState state = heard.last;
  const bool has_filters = robot.protocol == fci::VersionOf(fci::Protocol::k5);
  if (is_idle && note(SendSettings(check.backend, SettingsOf(scenario.onboard, has_filters)))) {
    const loop::ListenReport now = listen(kShortly);
    if (now.states > 0) state = now.last;
    note(CheckPayload(state, scenario, robot));
  }
  note(CheckTorques(state, scenario, robot));
  note(CheckStart(state, scenario, start));
  note(CheckCommunication(heard, check.listening, check.time));
  note(CheckScheduler(heard.notices, check.time));
  return all_ok;
}

}  // namespace twin::run
