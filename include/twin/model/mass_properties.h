#pragma once

#include "twin/core/joint_vector.h"

namespace twin::model {

/// Symmetric 3 x 3 matrix by its upper triangle; for an inertia, kg m^2.
struct SymmetricMatrix3 {
  double xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;
};

/// Inertial parameters of one link, in its own joint frame (modified DH).
struct LinkParameters {
  double m = 0;        ///< mass, kg
  Vector3 com{};       ///< centre of mass in the joint frame
  SymmetricMatrix3 I;  ///< about the centre of mass, axes of the joint frame
};

/// Mass moments of a rigid body about the origin of a frame, in its axes. The dynamics are linear
/// in them, so moments of bodies fixed to each other add.
struct MassMoments {
  double m = 0;        ///< zeroth: mass, kg
  Vector3 h{};         ///< first: mass times centre of mass, kg m
  SymmetricMatrix3 I;  ///< second: inertia about the frame's origin

  /// Moments of a body of mass m, centre of mass c and inertia I_c about it: h = m c,
  /// I = I_c - m [c]x^2.
  [[nodiscard]] static constexpr MassMoments Of(double m, const Vector3& c,
                                                const SymmetricMatrix3& I_c) noexcept {
    const Vector3 h{m * c[0], m * c[1], m * c[2]};
    return {m,
            h,
            {I_c.xx + h[1] * c[1] + h[2] * c[2], I_c.xy - h[0] * c[1], I_c.xz - h[0] * c[2],
             I_c.yy + h[0] * c[0] + h[2] * c[2], I_c.yz - h[1] * c[2],
             I_c.zz + h[0] * c[0] + h[1] * c[1]}};
  }
};

/// A rigid body beyond the flange: end effector, load, or both.
struct Payload {
  double m = 0;     ///< mass, kg
  Vector3 F_x_C{};  ///< centre of mass in the flange frame, m
  Matrix3 I{};      ///< inertia about the centre of mass, flange axes, kg m^2
};

/// Combines both bodies, as FCI clients combine end effector and load: masses add; the centre of
/// mass is the mass-weighted mean; each inertia is moved to the flange, added, and moved to the
/// common centre. A body without mass contributes nothing; zero total mass gives zero. Source: FCI
/// protocol 5, fields the client derives itself.
[[nodiscard]] Payload Combine(const Payload& a, const Payload& b) noexcept;

}  // namespace twin::model
