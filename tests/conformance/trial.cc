#include "conformance/trial.h"

#include "conformance/pose_math.h"
#include "twin/core/time.h"

namespace twin::test {
namespace {

double MinimumJerk(double x) {
  return x * x * x * (10 + x * (-15 + 6 * x));
}

/// X turned by phi about a point.
Transform TurnedAbout(const Transform& X, const Vector3& point, const Vector3& phi) {
  Transform arm = X;
  for (std::size_t i = 0; i < 3; ++i) arm[12 + i] -= point[i];
  // The position turns as a column of the rotation does.
  Transform columns = kIdentityTransform;
  for (std::size_t i = 0; i < 3; ++i) columns[i] = arm[12 + i];
  const Transform turned_position = Turned(columns, phi);
  Transform turned = Turned(X, phi);
  for (std::size_t i = 0; i < 3; ++i) turned[12 + i] = point[i] + turned_position[i];
  return turned;
}

std::function<double(double)> Constant(double value) {
  return [value](double) { return value; };
}

}  // namespace

Path JointPath(const RobotState& start, std::size_t joint) {
  Path path;
  path.q = [q = start.q_d, joint](double s) {
    JointVector moved = q;
    moved[joint] += s;
    return moved;
  };
  const Vector3 shoulder{0, 0, 0.333};
  path.pose = [X = start.O_T_EE_c, shoulder](double s) {
    return TurnedAbout(X, shoulder, {0, s, 0});  // the axis of joint 2 where joint 1 is at zero
  };
  path.elbow = Constant(start.elbow_c[0]);
  return path;
}

Path TranslationPath(const RobotState& start) {
  Path path;
  path.pose = [X = start.O_T_EE_c](double s) {
    Transform moved = X;
    moved[12] += s;
    return moved;
  };
  path.elbow = Constant(start.elbow_c[0]);
  return path;
}

Path RotationPath(const RobotState& start) {
  Path path;
  path.pose = [X = start.O_T_EE_c](double s) { return Turned(X, {s, 0, 0}); };
  path.elbow = Constant(start.elbow_c[0]);
  return path;
}

Path ElbowPath(const RobotState& start) {
  Path path;
  path.pose = [X = start.O_T_EE_c](double) { return X; };
  path.elbow = [elbow = start.elbow_c[0]](double s) { return elbow + s; };
  return path;
}

bool Trial::StartSilent(const std::function<Path(const RobotState&)>& path, bool with_elbow) {
  if (!rig_.StartMotion(modes_)) return false;
  path_ = path(state());
  if (!with_elbow) path_.elbow = nullptr;
  return true;
}

bool Trial::Start(const std::function<Path(const RobotState&)>& path, bool with_elbow) {
  if (!StartSilent(path, with_elbow)) return false;
  Stay(1);
  return true;
}

RobotCommand Trial::CommandTo(double s) const {
  RobotCommand command;
  command.message_id = state().message_id;
  command.tau_J_d = state().tau_J_d;
  switch (modes_.generator) {
    case MotionGeneratorMode::kJointPosition: command.q_c = path_.q(s); break;
    case MotionGeneratorMode::kJointVelocity: {
      const JointVector q = path_.q(s);
      for (std::size_t i = 0; i < kJoints; ++i) command.dq_c[i] = (q[i] - state().q_d[i]) / kT;
      break;
    }
    case MotionGeneratorMode::kCartesianPosition: command.O_T_EE_c = path_.pose(s); break;
    default: command.O_dP_EE_c = TwistBetween(state().O_T_EE_c, path_.pose(s)); break;
  }
  const bool is_cartesian = modes_.generator >= MotionGeneratorMode::kCartesianPosition;
  if (is_cartesian && path_.elbow) {
    command.valid_elbow = true;
    command.elbow_c = {path_.elbow(s), state().elbow_c[1]};
  }
  return command;
}

void Trial::To(double s, const Change& change) {
  if (!moves()) return;
  const double ds = (s - s_) / kT;
  dds_ = (ds - ds_) / kT;
  ds_ = ds;
  s_ = s;
  RobotCommand command = CommandTo(s);
  if (change) change(command);
  rig_.Answer(command);
}

void Trial::Accelerate(double dds, const Change& change) {
  To(s_ + kT * (ds_ + kT * dds), change);
}

void Trial::Stay(int cycles, const Change& change) {
  for (int i = 0; i < cycles; ++i) To(s_, change);
}

void Trial::Ease(double s, int cycles) {
  const double from = s_;
  for (int k = 1; k <= cycles && moves(); ++k) {
    To(from + (s - from) * MinimumJerk(static_cast<double>(k) / cycles));
  }
}

void Trial::SpeedUp(double ds, int cycles, int hold) {
  const double from = ds_;
  for (int k = 1; k <= cycles && moves(); ++k) {
    const double next = from + (ds - from) * MinimumJerk(static_cast<double>(k) / cycles);
    To(s_ + kT * next);
  }
  for (int k = 0; k < hold && moves(); ++k) To(s_ + kT * ds);
}

void Trial::RampAcceleration(double dds, int cycles) {
  const double from = dds_;
  for (int k = 1; k <= cycles && moves(); ++k) Accelerate(from + (dds - from) * k / cycles);
}

void Trial::Lose(int cycles) {
  for (int i = 0; i < cycles && moves(); ++i) rig_.Cycle();
}

void Trial::Finish() {
  for (int i = 0; i < 100 && moves(); ++i) {
    RobotCommand command = CommandTo(s_);
    command.motion_generation_finished = true;
    rig_.Answer(command);
  }
}

}  // namespace twin::test
