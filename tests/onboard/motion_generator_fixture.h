#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "model/model_samples.h"
#include "support/panda_limits.h"
#include "twin/model/transform.h"
#include "twin/onboard/motion_generator.h"

// Streams of commands for a MotionGenerator at the ready pose with a hand.
namespace twin::onboard {

using Mode = MotionGeneratorMode;

inline constexpr double kT = 1e-3;

/// A MotionGenerator at the ready pose, driven one call a cycle.
struct Driver {
  explicit Driver(Mode mode, const GeneratorLimits& limits = PandaGeneratorLimits())
      : generator(limits, model::kReady) {
    generator.SetEndEffector(model::kHandPose);
    generator.Start({.generator = mode});
    start = generator.cartesian();
  }

  static GeneratorLimits PandaGeneratorLimits() {
    GeneratorLimits limits;
    limits.joints = test::PandaLimits();
    limits.cartesian = test::PandaCartesianLimits();
    return limits;
  }

  /// @returns the errors of the cycle.
  std::vector<RobotError> Send(const RobotCommand& command) {
    found = generator.Take(command, is_first, ++cycle);
    is_first = false;
    return Errors();
  }
  std::vector<RobotError> Lose() {
    found = generator.Hold(++cycle);
    return Errors();
  }
  /// Sends until an error comes. @returns the errors.
  std::vector<RobotError> SendAll(const std::vector<RobotCommand>& commands) {
    std::vector<RobotError> errors;
    for (const RobotCommand& command : commands) {
      errors = Send(command);
      if (!errors.empty()) break;
    }
    return errors;
  }
  [[nodiscard]] std::vector<RobotError> Errors() const {
    std::vector<RobotError> errors;
    for (const Violation& violation : found.items()) errors.push_back(violation.error);
    return errors;
  }

  MotionGenerator generator;
  CartesianReference start;
  Violations found;
  bool is_first = true;
  std::uint64_t cycle = 0;
};

/// What moves: along y, about the base's z, or the elbow (or the joint of a joint generator).
enum class Axis : std::uint8_t { kTranslation = 0, kRotation = 1, kElbow = 2, kJoint };

/// A motion along one axis from rest, as a sequence of velocities.
struct Motion {
  Axis axis;
  std::size_t joint = 0;

  /// The commands of these velocities (m/s or rad/s), one a cycle, for a driver that has started.
  [[nodiscard]] std::vector<RobotCommand> Commands(const Driver& driver, Mode mode,
                                                   const std::vector<double>& velocities,
                                                   bool has_elbow) const {
    std::vector<RobotCommand> commands;
    double way = 0;
    for (const double velocity : velocities) {
      way += kT * velocity;
      commands.push_back(At(driver, mode, way, velocity, has_elbow));
    }
    return commands;
  }

  [[nodiscard]] RobotCommand At(const Driver& driver, Mode mode, double way, double velocity,
                                bool has_elbow) const {
    RobotCommand command;
    if (axis == Axis::kJoint) {
      command.q_c = driver.generator.joints().q_d;
      command.q_c[joint] += way;
      command.dq_c[joint] = velocity;
      return command;
    }
    Eigen::Vector3d p = model::Position(driver.start.O_T_EE_c);
    if (axis == Axis::kTranslation) p.y() += way;
    const double turn = axis == Axis::kRotation ? way : 0;
    command.O_T_EE_c = model::Turned(driver.start.O_T_EE_c, {0, 0, turn}, p);
    if (mode == Mode::kCartesianVelocity) command.O_T_EE_c = {};
    if (axis == Axis::kTranslation) command.O_dP_EE_c[1] = velocity;
    if (axis == Axis::kRotation) command.O_dP_EE_c[5] = velocity;
    command.valid_elbow = has_elbow || axis == Axis::kElbow;
    if (command.valid_elbow) {
      command.elbow_c = driver.start.elbow_c;
      if (axis == Axis::kElbow) command.elbow_c[0] += way;
    }
    return command;
  }
};

/// Velocities of a motion whose largest jerk is at its beginning.
inline std::vector<double> OneJerk(double jerk) {
  return {kT * kT * jerk};
}
/// ... whose acceleration grows in four equal steps, to the given one.
inline std::vector<double> Accelerating(double acceleration) {
  std::vector<double> velocities;
  double v = 0;
  for (int k = 1; k <= 4; ++k) velocities.push_back(v += kT * acceleration * k / 4);
  return velocities;
}
/// ... whose velocity grows smoothly to the given one in so many cycles.
inline std::vector<double> Speeding(double velocity, int cycles = 400) {
  std::vector<double> velocities;
  for (int k = 1; k <= cycles; ++k) {
    velocities.push_back(velocity * 0.5 * (1 - std::cos(std::numbers::pi * k / cycles)));
  }
  return velocities;
}

/// The pose motion of libfranka's examples: a circle of 0.3 m in the plane xz, in 10 s.
inline RobotCommand CircleAt(const Driver& driver, int cycle, bool has_elbow) {
  const double angle = std::numbers::pi / 4 * (1 - std::cos(std::numbers::pi / 5 * kT * cycle));
  RobotCommand command;
  command.O_T_EE_c = driver.start.O_T_EE_c;
  command.O_T_EE_c[12] += 0.3 * std::sin(angle);
  command.O_T_EE_c[14] += 0.3 * (std::cos(angle) - 1);
  command.valid_elbow = has_elbow;
  if (has_elbow) command.elbow_c = driver.start.elbow_c;
  return command;
}

}  // namespace twin::onboard
