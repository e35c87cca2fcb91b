#pragma once

#include <functional>
#include <memory>

#include "conformance/rig.h"
#include "contract/backend_harness.h"
#include "twin/core/modes.h"
#include "twin/robot/robot_config.h"

namespace twin::test {

/// Where a motion is after the way s, from where it starts: joint positions for joint generators,
/// a pose of EE (and an elbow) for Cartesian ones.
struct Path {
  std::function<JointVector(double s)> q;
  std::function<Transform(double s)> pose;
  std::function<double(double s)> elbow;  ///< empty: no elbow is commanded
};

/// Turns one joint alone: for Cartesian generators joint 2 about its axis, through the shoulder,
/// which at an arm in one plane no other joint can do better, elbow commanded or not.
[[nodiscard]] Path JointPath(const RobotState& start, std::size_t joint);
/// Moves EE along base x, or turns it about base x.
[[nodiscard]] Path TranslationPath(const RobotState& start);
[[nodiscard]] Path RotationPath(const RobotState& start);
/// Leaves EE where it is and moves the elbow.
[[nodiscard]] Path ElbowPath(const RobotState& start);

/// One motion along a path, commanded cycle by cycle in whatever its motion generator understands;
/// the way s, its velocity and acceleration are given by hand. Commands go on only while the robot
/// shows Move.
///
/// Threads: one.
class Trial {
 public:
  Trial(Rig& rig, const MotionModes& modes) : rig_(rig), modes_(modes) {}

  [[nodiscard]] Rig& rig() { return rig_; }
  [[nodiscard]] const RobotState& state() const { return rig_.state(); }
  [[nodiscard]] bool moves() const { return state().robot_mode == RobotMode::kMove; }

  /// Starts the motion, rests for a command, and takes the path from there.
  /// @returns whether it was granted.
  bool Start(const std::function<Path(const RobotState&)>& path, bool with_elbow);
  /// The same without any command yet.
  bool StartSilent(const std::function<Path(const RobotState&)>& path, bool with_elbow);

  /// The command that goes to s; the next one to be sent. @param after  changes it before.
  using Change = std::function<void(RobotCommand&)>;
  void To(double s, const Change& change = {});
  /// One cycle with this acceleration of s.
  void Accelerate(double dds, const Change& change = {});
  /// `cycles` at the velocity and acceleration of rest: s stays.
  void Stay(int cycles, const Change& change = {});
  /// From rest to rest by the minimum-jerk polynomial.
  void Ease(double s, int cycles);
  /// To a velocity of s, and there for `hold` cycles; the velocity rises as Ease() moves.
  void SpeedUp(double ds, int cycles, int hold = 0);
  /// Acceleration of s, up to dds in equal steps.
  void RampAcceleration(double dds, int cycles);
  /// `cycles` without a command.
  void Lose(int cycles);
  /// The finished command until the motion is over.
  void Finish();

  [[nodiscard]] double s() const { return s_; }

 private:
  [[nodiscard]] RobotCommand CommandTo(double s) const;

  Rig& rig_;
  MotionModes modes_;
  Path path_;
  double s_ = 0;
  double ds_ = 0;
  double dds_ = 0;
};

}  // namespace twin::test
