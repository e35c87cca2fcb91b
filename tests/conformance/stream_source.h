#pragma once

#include <array>

#include "conformance/dice.h"
#include "conformance/stream_plan.h"
#include "twin/core/robot_state.h"

namespace twin::test {

/// Speeds a scalar or vector up and down within limits of acceleration and jerk: the acceleration
/// of the next cycle that brings a velocity towards its target.
struct Tracker {
  double a_max = 0;
  double j_max = 0;

  template <std::size_t N>
  [[nodiscard]] std::array<double, N> Next(const std::array<double, N>& v,
                                           const std::array<double, N>& a,
                                           const std::array<double, N>& v_target) const;
};

/// Makes the commands of a stream from what the states show, as a client does: smooth random
/// motion within the share `vigour` of the limits, up to the very limits and beyond where the
/// plan's edges say so. The motion goes on from the state, so that lost cycles do not tear it.
class StreamSource {
 public:
  StreamSource(const StreamPlan& plan, const RobotState& start);

  /// The next command. @param settles  the motion is to come to rest.
  [[nodiscard]] RobotCommand Next(const RobotState& state, bool settles);

  /// From now on an axis goes to `size` times its limit.
  void SetEdge(const Disturbance& disturbance);
  void SwitchElbow() { with_elbow_ = !with_elbow_; }
  void SetFilters(const setting::Filters& filters) { filters_ = filters; }

  /// Whether the motion may be finished: standing still from here is within half of the limits.
  [[nodiscard]] bool MayFinish(const RobotState& state) const;

 private:
  [[nodiscard]] JointVector JointAcceleration(const RobotState& state, bool settles);
  [[nodiscard]] Vector6 CartesianAcceleration(const RobotState& state, bool settles);
  [[nodiscard]] double ElbowAcceleration(const RobotState& state, bool settles);
  void FillJoints(const RobotState& state, bool settles, RobotCommand& command);
  void FillCartesian(const RobotState& state, bool settles, RobotCommand& command);
  void FillTorque(const RobotState& state, RobotCommand& command);
  void DrawTargets();

  MotionModes modes_;
  bool with_elbow_;
  double vigour_;
  JointLimits joints_;
  CartesianLimits cartesian_;
  setting::Filters filters_;
  Dice dice_;

  int cycles_to_draw_ = 0;
  JointVector dq_target_{};  ///< shares of the limits
  Vector6 twist_target_{};   ///< the same
  double elbow_target_ = 0;
  JointVector tau_rate_{};
  Transform home_;  ///< Cartesian motions stay about it
  double elbow_home_ = 0;

  bool has_edge_ = false;
  Disturbance edge_;
};

}  // namespace twin::test
