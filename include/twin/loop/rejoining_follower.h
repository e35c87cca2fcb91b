#pragma once

#include <cstdint>

#include "twin/control/controller.h"
#include "twin/core/limits.h"
#include "twin/core/realtime.h"
#include "twin/core/robot_state.h"
#include "twin/core/time.h"
#include "twin/reference/rejoining_generator.h"
#include "twin/reference/resampler.h"
#include "twin/reference/target.h"

namespace twin::loop {

/// Generator::kRejoining on one interface: deposits through a resampler, what losses leave taken
/// away by the saturated correction.
///   joint positions   r = the resampled positions;
///   joint velocities  r = the integral of the resampled velocities from where the motion began, so
///                     that lost commands lose no way; the command is (q_c - q_d) / T;
///   poses             the same law for translation and rotation.
/// A stalled source stands at its last position or pose, which the correction leads to within its
/// bounds; its velocity is zero, and no way is made up for.
///
/// Threads: one. Real-time: noexcept, allocates nothing.
class RejoiningFollower {
 public:
  /// @pre interface is one of motions. @throws InputError as Resampler.
  RejoiningFollower(control::CommandInterface interface, double source_rate_hz,
                    const JointLimits& joints, const CartesianLimits& cartesian);

  /// A motion begins where `state` says the reference is.
  void Reset(const RobotState& state) noexcept TWIN_REALTIME;

  /// The source as it is in the cycle to be commanded.
  /// @param fresh   `target` was deposited since the last call, at `source_time` of its clock.
  /// @param cycles  of the robot since the last call. @param stalled  as the source counts.
  void Observe(const RobotState& state, const reference::Target& target, bool fresh,
               std::uint64_t cycles, Time source_time, bool stalled) noexcept TWIN_REALTIME;

  /// Fills the field of `command` that the interface uses.
  void Command(const RobotState& state, RobotCommand& command) const noexcept TWIN_REALTIME;

  /// Whether the source is at rest, and q_d (or the pose) within `tolerance`, rad (or m), of it.
  [[nodiscard]] bool Arrived(const RobotState& state,
                             double tolerance) const noexcept TWIN_REALTIME;

  /// Where the source is when the command acts, for the record: positions with their velocity, or
  /// the pose; what else the newest deposit has is passed on.
  [[nodiscard]] const reference::Target& source() const noexcept { return source_; }

 private:
  void Advance() noexcept;
  [[nodiscard]] reference::Played<JointVector> Joints() const noexcept;
  [[nodiscard]] reference::Played<Transform> Poses() const noexcept;

  control::CommandInterface interface_;
  reference::Resampler joints_;
  reference::PoseResampler poses_;
  reference::RejoiningGenerator joint_generator_;
  reference::RejoiningPoseGenerator pose_generator_;
  bool stalled_ = false;
  JointVector way_{};  ///< r(k+1) on the interface of velocities, rad
  reference::Target source_;
};

}  // namespace twin::loop
