#include <algorithm>
#include <chrono>
#include <cmath>

#include "conformance/arm_oracle.h"
#include "conformance/error_table.h"
#include "conformance/pose_math.h"
#include "twin/core/setting.h"

// Rows of errors that what is measured raises.

namespace twin::test {
namespace {

using Mode = MotionGeneratorMode;

constexpr std::array kGenerators{Mode::kJointPosition, Mode::kJointVelocity,
                                 Mode::kCartesianPosition, Mode::kCartesianVelocity};
constexpr std::size_t kWrist = 6;

ErrorRow Row(RobotError error, Mode mode, ControllerMode controller, std::string cause,
             std::string neighbour) {
  ErrorRow row;
  row.error = error;
  row.modes = {controller, mode};
  row.cause = std::move(cause);
  row.neighbour = std::move(neighbour);
  return row;
}

Path WristPath(const RobotState& start) {
  return JointPath(start, kWrist);
}
Path ShoulderPath(const RobotState& start) {
  return JointPath(start, 1);
}

/// Collision thresholds that nothing here reaches.
setting::CollisionBehavior NoCollisions() {
  setting::CollisionBehavior behavior;
  behavior.lower_torque_acc.fill(1000);
  behavior.upper_torque_acc = behavior.lower_torque_acc;
  behavior.lower_torque_nominal = behavior.lower_torque_acc;
  behavior.upper_torque_nominal = behavior.lower_torque_acc;
  behavior.lower_force_acc.fill(1e5);
  behavior.upper_force_acc = behavior.lower_force_acc;
  behavior.lower_force_nominal = behavior.lower_force_acc;
  behavior.upper_force_nominal = behavior.lower_force_acc;
  return behavior;
}

// --- by an external torque on the MuJoCo plant ---------------------------------------------------

/// Commands the torque of joint 7 for a cycle, as fast as its rate may change.
void PushWrist(Trial& trial, double tau) {
  trial.Stay(1, [tau](RobotCommand& command) {
    command.tau_J_d[kWrist] += std::clamp(tau - command.tau_J_d[kWrist], -0.9, 0.9);
  });
}

ErrorRow BeyondPositionRow() {
  ErrorRow row =
      Row(RobotError::kJointPositionLimitsViolation, Mode::kJointVelocity,
          ControllerMode::kExternalController, "a commanded torque leads joint 7 against its end",
          "a commanded torque leads it to 10 mrad before its end");
  row.plant = robot::PlantKind::kMujoco;
  row.outside = 0.02;
  row.inside = -0.01;
  row.axis = kWrist;
  row.persists = true;
  row.prepare = [](robot::RobotConfig& robot, double) {
    robot.onboard.collision_behavior = NoCollisions();
    robot.onboard.sensing.measured.q_margin_rad = 0;
    robot.q_start[kWrist] = robot.onboard.limits.q_max[kWrist] - 0.05;
  };
  row.stream = [](Trial& trial, double x) {
    if (!trial.Start(WristPath, false)) return;
    const double target = trial.state().q[kWrist] + 0.05 + x;
    for (int k = 0; k < 1500 && trial.moves(); ++k) {
      const RobotState& s = trial.state();
      PushWrist(trial, 30 * (target - s.q[kWrist]) - 5 * s.dq[kWrist]);
    }
  };
  return row;
}

ErrorRow TooFastRow() {
  ErrorRow row =
      Row(RobotError::kJointVelocityViolation, Mode::kJointVelocity,
          ControllerMode::kExternalController,
          "a commanded torque turns joint 7 at 3 % above what may be measured", "at 3 % below");
  row.plant = robot::PlantKind::kMujoco;
  row.outside = 1.03;
  row.inside = 0.97;
  row.axis = kWrist;
  row.prepare = [](robot::RobotConfig& robot, double) {
    robot.onboard.collision_behavior = NoCollisions();
    robot.q_start[kWrist] = -2;
  };
  row.stream = [](Trial& trial, double x) {
    if (!trial.Start(WristPath, false)) return;
    const robot::RobotConfig robot = HarnessRobot(robot::PlantKind::kMujoco);
    const double fastest = x * robot.onboard.limits.dq_max[kWrist] *
                           (1 + robot.onboard.sensing.measured.velocity_margin);
    bool slows = false;
    for (int k = 0; k < 2000 && trial.moves(); ++k) {
      const double dq = trial.state().dq[kWrist];
      slows = slows || dq >= fastest;
      PushWrist(trial, slows ? -2 * dq : 4 * (fastest * 1.02 - dq) + 1);
    }
  };
  return row;
}

// --- by a push on the MuJoCo plant ---------------------------------------------------------------

/// Thresholds of which those count that `set` sets.
template <typename Set>
setting::CollisionBehavior Only(const Set& set) {
  setting::CollisionBehavior behavior = NoCollisions();
  set(behavior);
  return behavior;
}

/// @param force  N, at the threshold.
ErrorRow PushRow(RobotError error, const setting::CollisionBehavior& behavior, int axis,
                 double limit, const Vector3& force) {
  ErrorRow row = Row(error, Mode::kJointPosition, ControllerMode::kJointImpedance,
                     "link 7 is pushed with 120 % of what the threshold is", "with 80 %");
  row.plant = robot::PlantKind::kMujoco;
  row.outside = 1.2;
  row.inside = 0.8;
  row.axis = axis;
  row.limit = limit;
  row.persists = true;
  row.prepare = [behavior, force](robot::RobotConfig& robot, double x) {
    robot.onboard.collision_behavior = behavior;
    // The flange is turned by an eighth of a turn in the start pose; K is not.
    const double c = std::sqrt(0.5);
    robot.onboard.F_T_NE = {c, -c, 0, 0, c, c, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    plant::Push push;
    push.body = "panda_link7";
    push.begin = std::chrono::milliseconds(200);
    push.duration = std::chrono::milliseconds(600);
    push.rise = std::chrono::milliseconds(200);
    for (std::size_t i = 0; i < 3; ++i) push.force[i] = x * force[i];
    robot.plant.perturbations.emplace_back(push);
  };
  row.stream = [](Trial& trial, double) {
    if (trial.Start(ShoulderPath, false)) trial.Stay(1000);
  };
  return row;
}

void AddPushRows(std::vector<ErrorRow>& rows) {
  constexpr double kForce = 30;   // N
  constexpr double kTorque = 10;  // Nm, of joint 1
  const auto force = Only([](setting::CollisionBehavior& behavior) {
    behavior.lower_force_acc[0] = behavior.upper_force_acc[0] = kForce;
    behavior.lower_force_nominal[0] = behavior.upper_force_nominal[0] = kForce;
  });
  rows.push_back(PushRow(RobotError::kCartesianReflex, force, 0, kForce, {kForce, 0, 0}));
  const auto torque = Only([](setting::CollisionBehavior& behavior) {
    behavior.lower_torque_acc[0] = behavior.upper_torque_acc[0] = kTorque;
    behavior.lower_torque_nominal[0] = behavior.upper_torque_nominal[0] = kTorque;
  });
  // Joint 7 turns about a vertical there, so that the flange is right below its frame.
  const Transform O_T_F = ArmOracle(kHarnessStart).Pose();
  rows.push_back(
      PushRow(RobotError::kJointReflex, torque, 0, kTorque, {0, kTorque / O_T_F[12], 0}));
}

// --- on the ideal plant --------------------------------------------------------------------------

/// What a load that INT knows of, and that is not there, makes it take for external: 1 kg at the
/// flange.
constexpr double kGhost = 1;

JointVector GhostTorque(const JointVector& q) {
  const ArmOracle arm(q);
  const JointVector without = arm.Gravity({});
  const JointVector with = arm.Gravity({{.m = kGhost}});
  JointVector tau{};
  for (std::size_t i = 0; i < kJoints; ++i) tau[i] = without[i] - with[i];
  return tau;
}

ErrorRow GhostRow(RobotError error, Mode mode, int axis, const std::string& what,
                  const std::function<void(setting::CollisionBehavior&, double)>& set) {
  ErrorRow row = Row(
      error, mode, ControllerMode::kJointImpedance,
      "a load of 1 kg is set and not there: external " + what + " 0.1 % above its upper threshold",
      "0.1 % below");
  row.axis = axis;
  row.persists = true;
  row.stream = [set](Trial& trial, double x) {
    setting::CollisionBehavior behavior = NoCollisions();
    set(behavior, x);
    setting::Load load;
    load.m_load = kGhost;
    if (!trial.rig().Configure(behavior) || !trial.rig().Configure(load)) return;
    if (trial.Start(ShoulderPath, false)) trial.Stay(300);
  };
  return row;
}

void AddGhostRows(std::vector<ErrorRow>& rows, Mode mode) {
  constexpr std::size_t kJoint = 1;
  rows.push_back(GhostRow(RobotError::kJointReflex, mode, kJoint, "torque",
                          [](setting::CollisionBehavior& behavior, double x) {
                            const double tau = std::abs(GhostTorque(kHarnessStart)[kJoint]) / x;
                            behavior.lower_torque_nominal[kJoint] = tau;
                            behavior.upper_torque_nominal[kJoint] = tau;
                          }));
  constexpr std::size_t kAxis = 2;
  rows.push_back(GhostRow(RobotError::kCartesianReflex, mode, kAxis, "force",
                          [](setting::CollisionBehavior& behavior, double x) {
                            const double force = kGhost * 9.81 / x;
                            behavior.lower_force_nominal[kAxis] = force;
                            behavior.upper_force_nominal[kAxis] = force;
                          }));
}

/// EE's speed for each rad/s of the path's joint.
double Lever(const RobotState& start, std::size_t joint) {
  JointVector dq{};
  dq[joint] = 1;
  return Norm(Linear(ArmOracle(start.q).Twist(dq, start.F_T_EE)));
}

ErrorRow FastHandRow(Mode mode) {
  constexpr double kMost = 0.3;
  ErrorRow row = Row(RobotError::kCartesianVelocityViolation, mode, ControllerMode::kJointImpedance,
                     "EE moves 0.1 % faster than may be measured", "0.1 % slower");
  row.axis = 0;
  row.limit = kMost;
  row.prepare = [](robot::RobotConfig& robot, double) {
    robot.onboard.sensing.measured.translation_max_m_per_s = kMost;
  };
  row.stream = [](Trial& trial, double x) {
    if (trial.Start(ShoulderPath, false)) {
      trial.SpeedUp(x * kMost / Lever(trial.state(), 1), 300, 5);
    }
  };
  return row;
}

ErrorRow PowerRow() {
  constexpr double kMost = 50;
  ErrorRow row = Row(
      RobotError::kPowerLimitViolation, Mode::kJointVelocity, ControllerMode::kExternalController,
      "joint 1 turns at 1 rad/s under a torque 0.1 % above what the power allows", "0.1 % below");
  row.limit = kMost;
  row.prepare = [](robot::RobotConfig& robot, double) {
    robot.onboard.sensing.measured.power_max_W = kMost;
  };
  row.stream = [](Trial& trial, double x) {
    if (!trial.Start([](const RobotState& start) { return JointPath(start, 0); }, false)) return;
    trial.SpeedUp(1, 300);
    for (int k = 0; k < 200 && trial.moves(); ++k) {
      trial.Accelerate(0, [x](RobotCommand& command) {
        command.tau_J_d[0] = std::min(command.tau_J_d[0] + 0.9, x * kMost);
      });
    }
  };
  return row;
}

ErrorRow TorqueRangeRow(Mode mode) {
  constexpr std::size_t kJoint = 3;
  ErrorRow row = Row(RobotError::kTauJRangeViolation, mode, ControllerMode::kJointImpedance,
                     "joint 4 carries 0.1 % more than the range of its sensor", "0.1 % less");
  row.axis = kJoint;
  row.prepare = [](robot::RobotConfig& robot, double x) {
    JointVector range = robot.onboard.limits.tau_max;
    range[kJoint] = std::abs(ArmOracle(robot.q_start).Gravity({})[kJoint]) / x;
    robot.onboard.sensing.measured.tau_J_range = range;
  };
  row.stream = [](Trial& trial, double) {
    if (trial.Start(ShoulderPath, false)) trial.Stay(10);
  };
  return row;
}

/// Where the arm folds onto itself.
constexpr JointVector kFolded{0, -0.785398163397, 0, -3.05, 0, -0.01, 0.785398163397};

/// The way there.
Path FoldingPath(const RobotState& start) {
  const auto q = [from = start.q_d](double s) {
    JointVector at = from;
    for (std::size_t i = 0; i < kJoints; ++i) at[i] += s * (kFolded[i] - from[i]);
    return at;
  };
  Path path;
  path.q = q;
  path.pose = [q, F_T_EE = start.F_T_EE](double s) { return ArmOracle(q(s)).Pose(F_T_EE); };
  path.elbow = [q](double s) { return q(s)[2]; };
  return path;
}

ErrorRow SelfCollisionRow(Mode mode) {
  ErrorRow row =
      Row(RobotError::kSelfCollisionAvoidanceViolation, mode, ControllerMode::kJointImpedance,
          "the arm folds until its parts are nearer than the clearance",
          "it stops 0.1 % of the way before");
  row.with_elbow = true;
  row.stream = [](Trial& trial, double x) {
    const Path path = FoldingPath(trial.state());
    const double clearance = robot::RobotConfig().onboard.sensing.measured.clearance_m;
    double near = 0;
    double far = 1;
    for (int i = 0; i < 60; ++i) {
      const double middle = (near + far) / 2;
      (ArmOracle(path.q(middle)).SelfDistance(true) > clearance ? near : far) = middle;
    }
    if (trial.Start(FoldingPath, true)) trial.Ease(x * near, 2500);
  };
  return row;
}

}  // namespace

std::vector<ErrorRow> MeasuredErrorRows() {
  std::vector<ErrorRow> rows{BeyondPositionRow(), TooFastRow(), PowerRow()};
  AddPushRows(rows);
  for (const Mode mode : kGenerators) {
    rows.push_back(FastHandRow(mode));
    rows.push_back(TorqueRangeRow(mode));
    rows.push_back(SelfCollisionRow(mode));
    AddGhostRows(rows, mode);
  }
  return rows;
}

}  // namespace twin::test
