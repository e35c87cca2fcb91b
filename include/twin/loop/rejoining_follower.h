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

/// Generator::kRejoining on one interface: resamples deposits; a saturated correction then removes
/// the error that losses cause.
///   joint positions   r = the resampled positions;
///   joint velocities  r = the resampled velocities, integrated from the motion's start, so that
///                     lost commands cost no displacement; the command is (q_c - q_d) / T;
///   poses             the same law for translation and rotation.
/// The reference of a stalled source is its last position or pose, to which the correction leads
/// within its bounds. A stalled velocity source has velocity zero; missed displacement is not
/// recovered.
///
/// Threads: one. Real-time: noexcept, allocates nothing.
class RejoiningFollower {
 public:
  /// @pre interface is not torque. @throws InputError as Resampler.
  RejoiningFollower(control::CommandInterface interface, double source_rate_hz,
                    const JointLimits& joints, const CartesianLimits& cartesian);

  /// Starts a motion from the reference in `state`.
  void Reset(const RobotState& state) noexcept TWIN_REALTIME;

  /// Updates the source for the cycle to be commanded.
  /// @param fresh   true if `target` was deposited since the last call.
  /// @param cycles  robot cycles since the last call. @param source_time  as CommandChain::Next().
  /// @param stalled  as CommandChain::stalled().
  void Observe(const RobotState& state, const reference::Target& target, bool fresh,
               std::uint64_t cycles, Time source_time, bool stalled) noexcept TWIN_REALTIME;

  /// Fills the field of `command` that the interface uses.
  void Command(const RobotState& state, RobotCommand& command) const noexcept TWIN_REALTIME;

  /// True when the source is at rest and q_d (or the pose) is within `tolerance` of it, rad (or m
  /// and rad). @param is_noisy  the source counts as at rest while it moves less than `tolerance`
  /// per cycle.
  [[nodiscard]] bool Arrived(const RobotState& state, double tolerance,
                             bool is_noisy) const noexcept TWIN_REALTIME;

  /// The source at the time when the command acts, for the record: positions with their velocity,
  /// or the pose. Other fields are those of the newest deposit.
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
  JointVector way_{};  ///< r(k+1) of a velocity source, rad
  reference::Target source_;
};

}  // namespace twin::loop
