#pragma once

#include <optional>

#include "twin/core/joint_vector.h"
#include "twin/core/limits.h"
#include "twin/core/robot_state.h"
#include "twin/core/time.h"
#include "twin/loop/command_chain.h"
#include "twin/onboard/joint_reference.h"

namespace twin::experiment {

/// The middle of every joint's range.
[[nodiscard]] JointVector MiddleOf(const JointLimits& limits) noexcept;

/// The workstation's command chain and the robot controller's reference behind it, cycle by cycle,
/// without a link between them: the robot takes every command in time. Joint 1 moves.
///
/// Threads: one.
class ChainBench {
 public:
  /// @param lambda  of the generator. @param q_d  initial reference of joint 1, rad.
  ChainBench(double lambda, double q_d);
  /// Any chain. @param q_d  initial reference, 7, rad; the other joints stay there.
  ChainBench(const loop::TickConfig& config, const JointVector& q_d);

  /// One cycle. @param q_ext, dq_ext  newest deposit, of joint 1: rad, rad/s.
  /// @param fresh  it was deposited since the last cycle.
  void Step(double q_ext, double dq_ext, bool fresh) noexcept {
    Answer(q_ext, dq_ext, fresh, false);
  }

  /// One cycle whose command is lost: the robot holds its acceleration.
  void StepLost(double q_ext, double dq_ext, bool fresh) noexcept {
    Answer(q_ext, dq_ext, fresh, true);
  }

  /// After the last cycle.
  [[nodiscard]] double q_d() const noexcept { return reference_.q_d[0]; }
  [[nodiscard]] double dq_d() const noexcept { return reference_.dq_d[0]; }
  [[nodiscard]] double ddq_d() const noexcept { return reference_.ddq_d[0]; }
  [[nodiscard]] double jerk() const noexcept { return reference_.dddq_d[0]; }
  /// Largest share of joint 1's limits of velocity, acceleration and jerk.
  [[nodiscard]] double LargestShare(const JointLimits& limits) const noexcept;
  /// record::TickRecord::margin of the last state, and whether the filter changed joint 1.
  [[nodiscard]] std::optional<double> margin() const noexcept { return chain_.margin(); }
  [[nodiscard]] bool kept_back() const noexcept { return (chain_.changed_joints() & 1U) != 0; }

 private:
  void Answer(double q_ext, double dq_ext, bool fresh, bool is_lost) noexcept;

  loop::CommandChain chain_;
  JointVector rest_;  ///< of the other joints
  onboard::JointReference reference_;
  RobotState state_;
  Time now_{};
  Time source_time_{};  ///< of the newest deposit
};

}  // namespace twin::experiment
