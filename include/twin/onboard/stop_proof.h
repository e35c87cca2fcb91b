#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "twin/core/joint_vector.h"
#include "twin/core/limits.h"
#include "twin/core/realtime.h"
#include "twin/core/robot_errors.h"
#include "twin/model/lab_limits.h"
#include "twin/onboard/joint_reference.h"

namespace twin::onboard {

/// Kind of a lab's limit.
enum class LimitKind : std::uint8_t {
  kRegion,      ///< a part of the robot leaves its region
  kJointRange,  ///< the stop would leave a joint's range
  kJointSpeed,
  kSpeed,   ///< of the end effector's origin
  kTurn,    ///< rate of turn of the end effector
  kForce,   ///< measured external force
  kTorque,  ///< measured external torque of a joint
  kNoStop,  ///< the reference has no stop within StopProof::kMostCycles
};

/// A broken limit. Trivially copyable.
struct BrokenLimit {
  LimitKind kind{};
  std::int8_t axis = -1;         ///< index of the region, or joint 0..6; -1: neither
  double value = 0;              ///< the offending value, signed like the bound
  double bound = 0;              ///< in the unit of the value
  model::RegionMargin region{};  ///< of kRegion: the plane that is passed
};

/// "limit \"a\": the hand reaches x = 1 m; it must be at most 1 m; the stop would pass it by 1 mm",
/// "limit speed.joints: joint 3 moves at 1.02 rad/s; the bound is 1 rad/s".
[[nodiscard]] std::string Describe(const model::LabLimits& limits, const BrokenLimit& breach);

/// @returns the first cap on measured forces and torques that is broken.
/// @param O_F_ext_hat_K  N and Nm. @param tau_ext  of the joints, Nm.
///
/// Threads: any. Real-time: noexcept, allocates nothing.
[[nodiscard]] std::optional<BrokenLimit> CheckForces(
    const model::LabLimits& limits, const Vector6& O_F_ext_hat_K,
    const JointVector& tau_ext) noexcept TWIN_REALTIME;

/// Proves that a reference can still stop within a lab's limits: that the stop by StopStep from it,
/// which INT and the workstation's tick execute, keeps every region, every cap and the joints'
/// ranges until it rests.
///
/// In each cycle k of the stop, with q_k, dq_k its reference and m(q) the least margin of all parts
/// from the planes of their regions (model::LeastMargin; >= 0: all inside):
///   |dq_k,i| <= cap_i,   |J(q_k) dq_k| <= caps of the end effector,   q_min <= q_k <= q_max,
///   m(q_k) + m(q_(k+1)) >= L_k,   L_k = sum_i r_i |q_(k+1),i - q_k,i|.
/// No part moves by more than r_i per rad of joint i, with r_i its largest distance from the
/// joint's axis, and a margin changes by at most the way of its part. So for every q on the
/// straight way from q_k to q_(k+1): m(q) >= (m(q_k) + m(q_(k+1)) - L_k)/2 >= 0. The arm is inside
/// in and between the cycles: a proof for the reference, not a sample.
///
/// Cost: m and the end effector's twist are computed only where the same bounds, from the last
/// computed m, do not decide. Far from every border one m is enough for the whole stop; along a
/// border each cycle of the stop takes one. At most kMostCycles cycles.
///
/// Not covered: the distance of the arm from its reference, and commands lost during the stop,
/// after which the robot holds an acceleration for longer than the proof assumes.
///
/// Threads: any (immutable). Real-time: noexcept, allocates nothing.
class StopProof {
 public:
  /// Cycles within which a stop must rest; a Panda's takes below 600 from any legal state.
  static constexpr int kMostCycles = 1000;

  /// @param joints  of the stop. @param limits  must be valid. Copies, hence not for real time.
  StopProof(const JointLimits& joints, model::LabLimits limits, const model::LimitedArm& arm);

  /// Changes the end effector. @param F_T_EE  rigid.
  void SetEndEffector(const Transform& F_T_EE) noexcept TWIN_REALTIME;

  /// @returns the first limit that the reference or the stop from it breaks; nullopt: none.
  [[nodiscard]] std::optional<BrokenLimit> Check(JointReference from) const noexcept TWIN_REALTIME;

  [[nodiscard]] const model::LabLimits& limits() const noexcept { return limits_; }

 private:
  /// A lower bound of the least margin, and its plane.
  struct Gap {
    model::RegionMargin nearest;
    bool is_exact = true;
  };
  [[nodiscard]] Gap GapAt(const JointVector& q) const noexcept;
  [[nodiscard]] std::optional<BrokenLimit> CheckJoints(
      const JointReference& reference) const noexcept;
  [[nodiscard]] std::optional<BrokenLimit> CheckTwist(
      const JointReference& reference) const noexcept;
  [[nodiscard]] std::optional<BrokenLimit> Advance(Gap& gap, const JointVector& from,
                                                   const JointVector& to) const noexcept;

  JointLimits joints_;
  model::LabLimits limits_;
  model::LimitedArm arm_;
  JointVector reach_{};
};

}  // namespace twin::onboard
