#pragma once

#include "twin/core/joint_vector.h"
#include "twin/core/realtime.h"
#include "twin/model/arm_model.h"

namespace twin::onboard {

/// INT's compensation of joint friction, the last term of the applied torque in every mode:
///   tau = tau_J_d + share tau_f(dq) + g(q),
/// with tau_f the residual friction of model/arm_model.h and dq the measured velocity. The
/// reported tau_J_d does not contain it.
///
/// The real robot compensates the friction of motor and gear by a law that is not public. tau_f was
/// identified *behind* that compensation and is the friction of the twin's plant by default, so the
/// default share is 0 and adds nothing, not even a zero. A share above 0 models a robot that
/// compensates better than the real one; 1 compensates all of tau_f. tau_f is smooth at rest, so
/// the compensation does not chatter; a share of at most 1 never drives a joint that has this
/// friction.
///
/// Source of the term's place: FCI protocol 5, control law of the external controller; the paper's
/// section on FCI timing (torque from B(q), C, f, g).
///
/// Threads: any (immutable). Real-time: noexcept, allocates nothing.
class FrictionCompensation {
 public:
  /// @param share  in [0, 1].
  explicit FrictionCompensation(double share) noexcept : share_(share) {}

  /// Adds share tau_f(dq) to `tau`. @param dq  rad/s. @param tau  Nm.
  void AddTo(JointVector& tau, const JointVector& dq) const noexcept TWIN_REALTIME {
    if (share_ == 0) return;
    const JointVector tau_f = model::ResidualFriction(dq);
    for (std::size_t i = 0; i < kJoints; ++i) tau[i] += share_ * tau_f[i];
  }

 private:
  double share_;
};

}  // namespace twin::onboard
