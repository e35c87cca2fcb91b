#pragma once

#include "twin/core/body_interface.h"
#include "twin/core/joint_vector.h"
#include "twin/core/realtime.h"
#include "twin/model/arm_model.h"

namespace twin::onboard {

/// Frames and bodies that setters change.
struct ArmSetup {
  Transform F_T_EE = kIdentityTransform;
  Transform EE_T_K = kIdentityTransform;
  model::Payload payload;  ///< end effector and load as configured in INT
};

/// Model quantities at the measured q that several parts of INT share, computed once per cycle.
///
/// A value type. Threads: any. Real-time: noexcept, allocates nothing.
struct MeasuredArm {
  MeasuredArm() noexcept : q(JointVector{}) {}
  /// @param q_measured  rad.
  MeasuredArm(const model::ArmModel& arm, const JointVector& q_measured,
              const ArmSetup& setup) noexcept TWIN_REALTIME
      : q(q_measured),
        EE(arm.MotionOf(model::Frame::kEndEffector, q, setup.F_T_EE)),
        g(arm.Gravity(q, setup.payload)) {}

  model::Configuration q;
  model::FrameMotion EE;
  JointVector g{};  ///< of arm, end effector and load, Nm
};

}  // namespace twin::onboard
