#pragma once

#include <cstdint>

#include "twin/core/joint_vector.h"
#include "twin/core/realtime.h"
#include "twin/core/setting.h"
#include "twin/onboard/violations.h"

namespace twin::onboard {

/// Compares the magnitudes of external torques and forces with the thresholds of
/// SetCollisionBehavior, with tolerance kLimitTolerance:
///   above the lower one  a contact, while it lasts;
///   above the upper one  a collision, latched until Clear(), and a violation while it lasts.
/// The `acc` thresholds count while the reference accelerates, the `nominal` ones otherwise. Forces
/// are those at K in its axes. Source: FCI protocol 5, contacts and collisions.
///
/// Threads: one. Real-time: all but SetBehavior; noexcept, allocates nothing.
class ContactMonitor {
 public:
  /// Keeps contacts until the next Update() and collisions until Clear().
  void SetBehavior(const setting::CollisionBehavior& behavior) noexcept { behavior_ = behavior; }

  /// @param tau_ext_hat  Nm. @param K_F_ext_hat_K  N, Nm.
  void Update(const JointVector& tau_ext_hat, const Vector6& K_F_ext_hat_K,
              bool accelerates) noexcept TWIN_REALTIME;

  /// joint_reflex and cartesian_reflex of the last Update(), each with the first joint or axis of K
  /// above its upper threshold.
  [[nodiscard]] Violations Collisions(std::uint64_t message_id) const noexcept TWIN_REALTIME;

  /// Unlatches the collisions.
  void Clear() noexcept;

  /// Levels: 1 above the threshold, else 0.
  [[nodiscard]] const JointVector& joint_contact() const noexcept { return joint_contact_; }
  [[nodiscard]] const Vector6& cartesian_contact() const noexcept { return cartesian_contact_; }
  [[nodiscard]] const JointVector& joint_collision() const noexcept { return joint_collision_; }
  [[nodiscard]] const Vector6& cartesian_collision() const noexcept { return cartesian_collision_; }

 private:
  setting::CollisionBehavior behavior_;
  bool accelerates_ = false;
  JointVector tau_ext_hat_{};
  Vector6 K_F_ext_hat_K_{};
  JointVector joint_contact_{};
  Vector6 cartesian_contact_{};
  JointVector joint_collision_{};
  Vector6 cartesian_collision_{};
};

}  // namespace twin::onboard
