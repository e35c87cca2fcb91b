#pragma once

#include "twin/core/joint_vector.h"
#include "twin/core/realtime.h"
#include "twin/core/robot_state.h"
#include "twin/model/arm_model.h"

namespace twin::onboard {

/// The two accelerometers on each of the links 0 to 5 of an FR3: proper acceleration, so that a
/// resting sensor shows 9.81 m/s^2 upwards, in the sensor's axes.
///
/// The velocity of a sensor is that of its link at the measured q and dq; its acceleration is the
/// difference of two cycles. Source of places and axes: fr3.urdf of franka_description 0.3 to 0.5
/// (Franka Robotics, Apache-2.0), joints linkN_accelerometer_top and _bottom. That INT reckons them
/// from the joints, where the robot measures, is a decision: vibration of the links is absent.
///
/// Threads: INT's. Real-time: noexcept, allocates nothing.
class Accelerometers {
 public:
  /// Restarts: the next Update() shows gravity alone.
  void Reset() noexcept { is_new_ = true; }

  /// Advances by one cycle. @param dq  rad/s.
  void Update(const model::ArmModel& arm, const model::Configuration& q,
              const JointVector& dq) noexcept TWIN_REALTIME;

  [[nodiscard]] const Accelerations& top() const noexcept { return top_; }        ///< m/s^2
  [[nodiscard]] const Accelerations& bottom() const noexcept { return bottom_; }  ///< m/s^2

 private:
  Accelerations top_{};
  Accelerations bottom_{};
  Accelerations v_top_{};     ///< of the last cycle, base axes, m/s
  Accelerations v_bottom_{};  ///< as v_top_
  bool is_new_ = true;
};

}  // namespace twin::onboard
