#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "twin/control/controller.h"
#include "twin/core/joint_vector.h"
#include "twin/core/realtime.h"
#include "twin/core/robot_state.h"
#include "twin/core/time.h"
#include "twin/reference/target.h"

namespace twin::loop {

/// Deviation of the measured arm from the workstation's targets over a motion:
///   q_ext - q of the joints, or the displacement of O_T_EE from the target pose.
/// The target is rate-matched; the arm is measured in the state after the answered one. A delay of
/// a few milliseconds contributes velocity times delay. A reference that does not follow its target
/// (a low-pass after the reference generator, a stopped robot) contributes far more.
struct Deviation {
  struct Joints {
    double largest = 0;     ///< magnitude, rad; infinite when a state was not finite
    std::size_t joint = 0;  ///< joint of the largest deviation, 0..6
    Time at{};              ///< time of the largest deviation: end of the state's read
    double rms = 0;         ///< root mean square of this joint over the motion, rad
  };
  struct Pose {
    double position = 0;  ///< largest distance of the origins, m; infinite as above
    Time position_at{};
    double angle = 0;  ///< largest angle between the rotations, rad; infinite as above
    Time angle_at{};
  };
  std::optional<Joints> joints;  ///< for joint targets
  std::optional<Pose> pose;      ///< for pose targets
};

/// Measures a Deviation state by state. A torque controller may give its path in the target's
/// joints or leave them at zero, which joint 4 cannot reach: then the meter measures nothing.
///
/// Threads: one. Real-time: noexcept, allocates nothing.
class DeviationMeter {
 public:
  explicit DeviationMeter(control::CommandInterface interface) noexcept : interface_(interface) {}

  /// Sets the target of the command that answered the state with this id.
  void Aim(std::uint64_t message_id, const reference::Target& target) noexcept TWIN_REALTIME {
    message_id_ = message_id;
    target_ = target;
  }
  /// Measures a state of the motion, if it follows the answered one.
  void Measure(const RobotState& state, Time read) noexcept TWIN_REALTIME;

  [[nodiscard]] Deviation Result() const noexcept;

 private:
  void MeasureJoints(const RobotState& state, Time read) noexcept;
  void MeasurePose(const RobotState& state, Time read) noexcept;

  control::CommandInterface interface_;
  std::uint64_t message_id_ = 0;
  reference::Target target_;
  Deviation largest_;
  std::array<double, kJoints> squares_{};
  std::uint64_t count_ = 0;
};

}  // namespace twin::loop
