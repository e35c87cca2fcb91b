#pragma once

#include "twin/core/robot_state.h"
#include "twin/core/time.h"
#include "twin/loop/command_chain.h"
#include "twin/onboard/joint_reference.h"

namespace twin::experiment {

/// The workstation's command chain and the reference that the robot's controller makes of its
/// commands, cycle by cycle, without the way between them: every command is taken, none is late.
/// For questions that are about the chain alone. Joint 1 is looked at.
///
/// Threads: one.
class ChainBench {
 public:
  /// @param lambda  the generator's. @param q_d  where the robot's reference is, of joint 1, rad.
  ChainBench(double lambda, double q_d);

  /// One cycle. @param q_ext, dq_ext  newest deposit, of joint 1: rad, rad/s.
  /// @param fresh  it was deposited since the last cycle.
  void Step(double q_ext, double dq_ext, bool fresh) noexcept;

  /// After the last cycle.
  [[nodiscard]] double q_d() const noexcept { return reference_.q_d[0]; }
  [[nodiscard]] double dq_d() const noexcept { return reference_.dq_d[0]; }
  [[nodiscard]] double jerk() const noexcept { return reference_.dddq_d[0]; }

 private:
  loop::CommandChain chain_;
  onboard::JointReference reference_;
  RobotState state_;
  Time now_{};
  Time source_time_{};  ///< of the newest deposit
};

}  // namespace twin::experiment
