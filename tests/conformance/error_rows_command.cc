#include <algorithm>
#include <cmath>

#include "conformance/error_table.h"
#include "conformance/pose_math.h"

// Rows of errors that commands raise.

namespace twin::test {
namespace {

using Mode = MotionGeneratorMode;

constexpr std::array kJointModes{Mode::kJointPosition, Mode::kJointVelocity};
constexpr std::array kCartesianModes{Mode::kCartesianPosition, Mode::kCartesianVelocity};

MotionModes Impedance(Mode mode) {
  return {ControllerMode::kJointImpedance, mode};
}

/// A start tolerance small enough that a step of its size is no discontinuity.
constexpr double kSmallStart = 1e-6;
/// How close a position limit is when a motion towards it starts, rad.
constexpr double kNear = 1e-3;
/// Share of the Cartesian limits that rows about them have, so that no joint is at its own limit.
constexpr double kLowered = 0.1;

auto AlongJoint(std::size_t joint) {
  return [joint](const RobotState& start) { return JointPath(start, joint); };
}

ErrorRow Row(RobotError error, Mode mode, std::string cause, std::string neighbour) {
  ErrorRow row;
  row.error = error;
  row.modes = Impedance(mode);
  row.cause = std::move(cause);
  row.neighbour = std::move(neighbour);
  return row;
}

/// Velocity, acceleration and jerk rows of one direction.
struct Bounds {
  double velocity;
  double acceleration;
  double jerk;
};
struct MotionErrors {
  RobotError velocity;
  RobotError acceleration;
  RobotError jerk;
};

using PathOf = std::function<Path(const RobotState&)>;

/// Largest velocity limit in rows about joints, rad/s: a joint reaches it with any arm's
/// acceleration, before a limit that depends on the position is smaller.
constexpr double kMostSpeed = 2.61;
/// The same of rows in which EE turns with the joint, which stays within EE's own limit.
constexpr double kMostTurn = 2.175;

void CapTurns(robot::RobotConfig& robot, double) {
  for (double& dq : robot.onboard.limits.dq_max) dq = std::min(dq, kMostTurn);
}
void CapSpeeds(robot::RobotConfig& robot, double) {
  for (double& dq : robot.onboard.limits.dq_max) dq = std::min(dq, kMostSpeed);
}

/// So that a position limit is reached: a velocity limit that depends on the position would be
/// broken before.
void LevelSpeeds(robot::RobotConfig& robot) {
  robot.onboard.limits.deceleration = JointVector{};
}

/// Three rows: the velocity, the acceleration, the jerk of the way goes to its bound.
void AddMotionRows(std::vector<ErrorRow>& rows, Mode mode, bool with_elbow,
                   const MotionErrors& errors, const std::string& what, int axis,
                   const Bounds& bounds, const PathOf& path,
                   const std::function<void(robot::RobotConfig&, double)>& prepare) {
  const auto add = [&](RobotError error, const std::string& quantity, double limit,
                       std::function<void(Trial&, double)> stream) {
    ErrorRow row =
        Row(error, mode, what + " " + quantity + " 0.1 % above its limit", "0.1 % below");
    row.with_elbow = with_elbow;
    row.axis = axis;
    row.limit = limit;
    row.prepare = prepare;
    row.stream = std::move(stream);
    rows.push_back(row);
  };
  add(errors.velocity, "velocity", bounds.velocity, [=](Trial& trial, double x) {
    if (trial.Start(path, with_elbow)) trial.SpeedUp(x * bounds.velocity, 700, 5);
  });
  add(errors.acceleration, "acceleration", bounds.acceleration, [=](Trial& trial, double x) {
    if (trial.Start(path, with_elbow)) trial.RampAcceleration(x * bounds.acceleration, 20);
  });
  add(errors.jerk, "jerk", bounds.jerk, [=](Trial& trial, double x) {
    if (trial.Start(path, with_elbow)) trial.Accelerate(x * bounds.jerk * 1e-3);
  });
}

void AddStartRow(std::vector<ErrorRow>& rows, RobotError error, Mode mode, bool with_elbow,
                 const std::string& what, int axis, const PathOf& path) {
  ErrorRow row = Row(error, mode, "the first command is " + what + " 0.1 % beyond the tolerance",
                     "0.1 % within it");
  row.with_elbow = with_elbow;
  row.axis = axis;
  row.limit = kSmallStart;
  row.prepare = [](robot::RobotConfig& robot, double) {
    robot.onboard.start_pose_tolerance_rad = kSmallStart;
    robot.onboard.start_translation_tolerance_m = kSmallStart;
    robot.onboard.start_rotation_tolerance_rad = kSmallStart;
    robot.onboard.start_elbow_tolerance_rad = kSmallStart;
  };
  row.stream = [path, with_elbow](Trial& trial, double x) {
    if (trial.StartSilent(path, with_elbow)) trial.To(x * kSmallStart);
  };
  rows.push_back(row);
}

CartesianLimits Lowered(CartesianLimits limits) {
  for (CartesianBound* bound : {&limits.translation, &limits.rotation, &limits.elbow}) {
    bound->dp_max *= kLowered;
    bound->ddp_max *= kLowered;
    bound->dddp_max *= kLowered;
  }
  return limits;
}

void LowerCartesianLimits(robot::RobotConfig& robot, double) {
  robot.onboard.cartesian = Lowered(robot.onboard.cartesian);
}

Bounds BoundsOf(const CartesianBound& bound) {
  return {bound.dp_max, bound.ddp_max, bound.dddp_max};
}

/// A joint goes towards the ends of its range at a velocity that is allowed up to a point on the
/// way.
void AddEndRows(std::vector<ErrorRow>& rows, Mode mode, std::size_t joint,
                const JointLimits& limits) {
  constexpr double kSpeed = 0.1;  // rad/s
  constexpr double kWay = 0.05;   // rad, to the point
  constexpr int kCycles = 300;    // until the speed is reached
  const double braking = kSpeed + limits.velocity_offset[joint];
  const double distance = braking * braking / (2 * limits.deceleration[joint]);
  for (const double side : {1.0, -1.0}) {
    ErrorRow row =
        Row(RobotError::kJointMotionGeneratorVelocityLimitsViolation, mode,
            "joint " + std::to_string(joint + 1) + " goes on towards its " +
                (side > 0 ? "upper" : "lower") + " end 1 mrad beyond where its velocity is allowed",
            "it goes to 1 mrad before");
    row.axis = static_cast<int>(joint);
    row.outside = kWay + 1e-3;
    row.inside = kWay - 1e-3;
    const double end = side > 0 ? limits.q_max[joint] : limits.q_min[joint];
    row.prepare = [=](robot::RobotConfig& robot, double) {
      // Shoulder and upper arm would fold the arm onto itself.
      if (joint == 1 || joint == 2) robot.q_start = {0, -0.3, 0, -0.9, 0, 1.6, 0.8};
      robot.q_start[joint] = end - side * (distance + kWay);
    };
    row.stream = [=](Trial& trial, double x) {
      const double held = x - kSpeed * kCycles * 1e-3 / 2;
      if (trial.Start(AlongJoint(joint), false)) {
        trial.SpeedUp(side * kSpeed, kCycles, static_cast<int>(held / (kSpeed * 1e-3)));
      }
    };
    rows.push_back(row);
  }
}

void AddFrameRow(std::vector<ErrorRow>& rows) {
  ErrorRow row =
      Row(RobotError::kCartesianPositionMotionGeneratorInvalidFrame, Mode::kCartesianPosition,
          "the rotation block is 6e-6 too large", "4e-6, within the 1e-5 that R^T R may be off");
  row.outside = 1 + 6e-6;
  row.inside = 1 + 4e-6;
  row.stream = [](Trial& trial, double x) {
    if (!trial.Start(TranslationPath, false)) return;
    trial.Stay(1, [x](RobotCommand& command) {
      for (std::size_t i = 0; i < 11; ++i) command.O_T_EE_c[i] *= x;
    });
  };
  rows.push_back(row);
}

void AddElbowRows(std::vector<ErrorRow>& rows, Mode mode) {
  AddStartRow(rows, RobotError::kCartesianMotionGeneratorStartElbowInvalid, mode, true, "an elbow",
              2, ElbowPath);
  ErrorRow late = rows.back();
  late.cause = "the first elbow after commands without one is 0.1 % beyond the tolerance";
  late.stream = [](Trial& trial, double x) {
    if (!trial.Start(ElbowPath, false)) return;
    trial.Stay(3);
    trial.Stay(1, [&](RobotCommand& command) {
      command.valid_elbow = true;
      command.elbow_c = trial.state().elbow_c;
      command.elbow_c[0] += x * kSmallStart;
    });
  };
  rows.push_back(late);
  ErrorRow sign = Row(RobotError::kCartesianMotionGeneratorElbowSignInconsistent, mode,
                      "the elbow's sign is the other one", "it is the arm's");
  sign.with_elbow = true;
  sign.outside = -1;
  sign.inside = 1;
  sign.stream = [](Trial& trial, double x) {
    if (!trial.Start(ElbowPath, true)) return;
    trial.Stay(1, [x](RobotCommand& command) { command.elbow_c[1] *= x; });
  };
  rows.push_back(sign);
  ErrorRow limit = Row(RobotError::kCartesianMotionGeneratorElbowLimitViolation, mode,
                       "the elbow goes 1e-6 rad beyond the limit of joint 3", "1e-6 rad before it");
  limit.with_elbow = true;
  limit.outside = kNear + 1e-6;
  limit.inside = kNear - 1e-6;
  limit.axis = 2;
  limit.limit = kNear;
  limit.prepare = [](robot::RobotConfig& robot, double) {
    LevelSpeeds(robot);
    robot.onboard.limits.q_max[2] = kNear;  // the arm starts with joint 3 at zero
  };
  limit.stream = [](Trial& trial, double x) {
    if (trial.Start(ElbowPath, true)) trial.Ease(x, 200);
  };
  rows.push_back(limit);
}

}  // namespace

std::vector<ErrorRow> JointErrorRows(const ArmLimits& arm) {
  const JointLimits& limits = arm.joints;
  constexpr MotionErrors kErrors{RobotError::kJointMotionGeneratorVelocityLimitsViolation,
                                 RobotError::kJointMotionGeneratorVelocityDiscontinuity,
                                 RobotError::kJointMotionGeneratorAccelerationDiscontinuity};
  std::vector<ErrorRow> rows;
  AddStartRow(rows, RobotError::kJointPositionMotionGeneratorStartPoseInvalid, Mode::kJointPosition,
              false, "for a joint", 3, AlongJoint(3));
  for (const Mode mode : kJointModes) {
    for (std::size_t joint = 0; joint < kJoints; ++joint) {
      AddMotionRows(rows, mode, false, kErrors, "joint " + std::to_string(joint + 1) + "'s",
                    static_cast<int>(joint),
                    {std::min(limits.dq_max[joint], kMostSpeed), limits.ddq_max[joint],
                     limits.dddq_max[joint]},
                    AlongJoint(joint), CapSpeeds);
      if (limits.deceleration[joint] > 0) AddEndRows(rows, mode, joint, limits);
    }
    for (const double side : {1.0, -1.0}) {
      ErrorRow row = Row(RobotError::kJointMotionGeneratorPositionLimitsViolation, mode,
                         std::string("a joint goes 1e-6 rad beyond its ") +
                             (side > 0 ? "upper" : "lower") + " limit",
                         "1e-6 rad before it");
      row.axis = 6;
      row.limit = limits.q_max[6];
      row.outside = kNear + 1e-6;
      row.inside = kNear - 1e-6;
      row.prepare = [side](robot::RobotConfig& robot, double) {
        LevelSpeeds(robot);
        robot.q_start[6] = side * (robot.onboard.limits.q_max[6] - kNear);
      };
      row.stream = [side](Trial& trial, double x) {
        if (trial.Start(AlongJoint(6), false)) trial.Ease(side * x, 200);
      };
      rows.push_back(row);
    }
  }
  return rows;
}

std::vector<ErrorRow> CartesianErrorRows(const ArmLimits& arm) {
  const CartesianLimits limits = Lowered(arm.cartesian);
  constexpr MotionErrors kErrors{RobotError::kCartesianMotionGeneratorVelocityLimitsViolation,
                                 RobotError::kCartesianMotionGeneratorVelocityDiscontinuity,
                                 RobotError::kCartesianMotionGeneratorAccelerationDiscontinuity};
  std::vector<ErrorRow> rows;
  AddFrameRow(rows);
  for (const bool with_elbow : {false, true}) {
    constexpr RobotError kStart = RobotError::kCartesianPositionMotionGeneratorStartPoseInvalid;
    AddStartRow(rows, kStart, Mode::kCartesianPosition, with_elbow, "translated", 0,
                TranslationPath);
    AddStartRow(rows, kStart, Mode::kCartesianPosition, with_elbow, "turned", 1, RotationPath);
    for (const Mode mode : kCartesianModes) {
      AddMotionRows(rows, mode, with_elbow, kErrors, "the translation's", 0,
                    BoundsOf(limits.translation), TranslationPath, LowerCartesianLimits);
      AddMotionRows(rows, mode, with_elbow, kErrors, "the rotation's", 1, BoundsOf(limits.rotation),
                    RotationPath, LowerCartesianLimits);
    }
  }
  for (const Mode mode : kCartesianModes) {
    AddMotionRows(rows, mode, true, kErrors, "the elbow's", 2, BoundsOf(limits.elbow), ElbowPath,
                  LowerCartesianLimits);
    AddElbowRows(rows, mode);
  }
  return rows;
}

std::vector<ErrorRow> CompletionErrorRows(const ArmLimits& arm) {
  const JointLimits& limits = arm.joints;
  constexpr int kJoint = 1;
  constexpr MotionErrors kErrors{
      RobotError::kCartesianMotionGeneratorJointVelocityLimitsViolation,
      RobotError::kCartesianMotionGeneratorJointVelocityDiscontinuity,
      RobotError::kCartesianMotionGeneratorJointAccelerationDiscontinuity};
  std::vector<ErrorRow> rows;
  for (const bool with_elbow : {false, true}) {
    for (const Mode mode : kCartesianModes) {
      AddMotionRows(rows, mode, with_elbow, kErrors,
                    "EE turns about the axis of joint 2: that joint's", kJoint,
                    {std::min(limits.dq_max[kJoint], kMostTurn), limits.ddq_max[kJoint],
                     limits.dddq_max[kJoint]},
                    AlongJoint(kJoint), CapTurns);
      ErrorRow row = Row(RobotError::kCartesianMotionGeneratorJointPositionLimitsViolation, mode,
                         "EE turns about the axis of joint 2 to 1e-6 rad beyond its limit",
                         "to 1e-6 rad before it");
      row.with_elbow = with_elbow;
      row.axis = kJoint;
      row.outside = kNear + 1e-6;
      row.inside = kNear - 1e-6;
      row.prepare = [](robot::RobotConfig& robot, double) {
        LevelSpeeds(robot);
        robot.onboard.limits.q_max[kJoint] = robot.q_start[kJoint] + kNear;
      };
      row.stream = [with_elbow](Trial& trial, double x) {
        if (trial.Start(AlongJoint(kJoint), with_elbow)) trial.Ease(x, 200);
      };
      rows.push_back(row);
    }
  }
  return rows;
}

std::vector<ErrorRow> CommonErrorRows(const ArmLimits& arm) {
  std::vector<ErrorRow> rows;
  for (const Mode mode : {Mode::kJointPosition, Mode::kJointVelocity, Mode::kCartesianPosition,
                          Mode::kCartesianVelocity}) {
    ErrorRow lost = Row(RobotError::kCommunicationConstraintsViolation, mode,
                        "20 cycles in a row without a command", "19, then one again");
    lost.outside = 20;
    lost.inside = 19;
    lost.limit = 20;
    lost.stream = [](Trial& trial, double x) {
      if (!trial.Start(AlongJoint(1), false)) return;
      trial.Lose(static_cast<int>(x));
      trial.Stay(1);
    };
    rows.push_back(lost);
    ErrorRow late = Row(RobotError::kCommunicationConstraintsViolation, mode,
                        "the first command does not come within its time", "it comes in time");
    late.outside = 1000;
    late.inside = 990;
    late.axis = 0;
    late.stream = [](Trial& trial, double x) {
      if (!trial.StartSilent(AlongJoint(1), false)) return;
      trial.Lose(static_cast<int>(x));
      trial.Stay(1);
    };
    rows.push_back(late);
    ErrorRow torque = Row(RobotError::kControllerTorqueDiscontinuity, mode,
                          "a torque changes at 0.1 % above 1000 Nm/s", "at 0.1 % below");
    torque.modes.controller = ControllerMode::kExternalController;
    torque.axis = 4;
    torque.limit = arm.joints.dtau_max[4];
    torque.stream = [](Trial& trial, double x) {
      if (!trial.Start(AlongJoint(1), false)) return;
      trial.Stay(1, [x](RobotCommand& command) { command.tau_J_d[4] += x; });
    };
    rows.push_back(torque);
  }
  return rows;
}

}  // namespace twin::test
