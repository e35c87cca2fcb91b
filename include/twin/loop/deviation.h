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

/// How far the measured arm was from where its workstation wanted it at that time, in a motion:
///   q_ext - q of the joints, or the displacement of O_T_EE from the target pose,
/// the target rate-matched, and measured in the state after the one it answered. A few milliseconds
/// of delay are part of it, velocity times delay; a reference that does not follow its target (a
/// low-pass behind the reference generator, a robot that stopped) shows as much more.
struct Deviation {
  struct Joints {
    double largest = 0;     ///< magnitude, rad; infinite when a state was not finite
    std::size_t joint = 0;  ///< of the largest, 0..6
    Time at{};              ///< of the largest: end of the state's read
    double rms = 0;         ///< of that joint, over the motion, rad
  };
  struct Pose {
    double position = 0;  ///< largest distance of the origins, m; infinite as above
    Time position_at{};
    double angle = 0;  ///< largest turn between them, rad; infinite as above
    Time angle_at{};
  };
  std::optional<Joints> joints;  ///< of targets of joints
  std::optional<Pose> pose;      ///< on the interface of poses
};

/// Measures it, state by state. Under torques a controller may tell where its path is, or leave the
/// target's joints at zero, which joint 4 of no state is: then nothing is measured.
///
/// Threads: one. Real-time: noexcept, allocates nothing.
class DeviationMeter {
 public:
  explicit DeviationMeter(control::CommandInterface interface) noexcept : interface_(interface) {}

  /// A command made from `target` answered the state with this id.
  void Aim(std::uint64_t message_id, const reference::Target& target) noexcept TWIN_REALTIME {
    message_id_ = message_id;
    target_ = target;
  }
  /// A state of the motion was read; it counts when it follows the one that was answered.
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
