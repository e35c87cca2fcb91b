#pragma once

#include "model/joint_chain.h"
#include "model/vector3.h"
#include "twin/model/mass_properties.h"

// Sums and frame changes of mass moments.
namespace twin::model::internal {

constexpr SymmetricMatrix3 operator+(const SymmetricMatrix3& a,
                                     const SymmetricMatrix3& b) noexcept {
  return {a.xx + b.xx, a.xy + b.xy, a.xz + b.xz, a.yy + b.yy, a.yz + b.yz, a.zz + b.zz};
}

constexpr Vector3 operator*(const SymmetricMatrix3& I, const Vector3& v) noexcept {
  return {I.xx * v[0] + I.xy * v[1] + I.xz * v[2], I.xy * v[0] + I.yy * v[1] + I.yz * v[2],
          I.xz * v[0] + I.yz * v[1] + I.zz * v[2]};
}

/// Two bodies fixed to each other, moments about the same origin.
constexpr MassMoments operator+(const MassMoments& a, const MassMoments& b) noexcept {
  return {a.m + b.m, a.h + b.h, a.I + b.I};
}

/// The payload's moments about the origin of joint frame 7, whose axes the flange shares.
constexpr MassMoments AboutJoint7(const Payload& payload) noexcept {
  const Matrix3& I = payload.I;
  const SymmetricMatrix3 symmetric_part{I[0], 0.5 * (I[1] + I[3]), 0.5 * (I[2] + I[6]),
                                        I[4], 0.5 * (I[5] + I[7]), I[8]};
  const Vector3& c = payload.F_x_C;
  return MassMoments::Of(payload.m, {c[0], c[1], c[2] + kFlangeOffset}, symmetric_part);
}

/// R I R^T for R the rotation of joint frame i in frame i - 1.
template <std::size_t i>
constexpr SymmetricMatrix3 ToParent(const SymmetricMatrix3& I, double s, double c) noexcept {
  // About z first; the in-plane part rotates by the double angle.
  const double sc = s * c;
  const double ss = s * s;
  const double difference = I.xx - I.yy;
  const double exchanged = ss * difference + 2 * sc * I.xy;
  const double xx = I.xx - exchanged;
  const double yy = I.yy + exchanged;
  const double xy = sc * difference + (1 - 2 * ss) * I.xy;
  const double xz = c * I.xz - s * I.yz;
  const double yz = s * I.xz + c * I.yz;
  if constexpr (kDh[i].sin_alpha == 0) return {xx, xy, xz, yy, yz, I.zz};
  if constexpr (kDh[i].sin_alpha == 1) return {xx, -xz, xy, I.zz, -yz, yy};
  if constexpr (kDh[i].sin_alpha == -1) return {xx, xz, -xy, I.zz, -yz, yy};
}

/// Moments about joint frame i, in the axes of frame i - 1 and about its origin. A shift by p adds
/// 2 (u p) E - u p^T - p u^T to the inertia, u = h + m p / 2.
template <std::size_t i>
constexpr MassMoments ToParent(const MassMoments& body, double s, double c) noexcept {
  constexpr Vector3 p = Offset(i);
  const Vector3 h = ToParent<i>(body.h, s, c);
  MassMoments shifted{body.m, h, ToParent<i>(body.I, s, c)};
  SymmetricMatrix3& I = shifted.I;
  Vector3 u = h;
  for (std::size_t k = 0; k < 3; ++k) {
    if (p[k] == 0) continue;
    u[k] += 0.5 * p[k] * body.m;
    shifted.h[k] += p[k] * body.m;
  }
  if constexpr (p[0] != 0) {
    I.yy += 2 * p[0] * u[0];
    I.zz += 2 * p[0] * u[0];
    I.xy -= p[0] * u[1];
    I.xz -= p[0] * u[2];
  }
  if constexpr (p[1] != 0) {
    I.xx += 2 * p[1] * u[1];
    I.zz += 2 * p[1] * u[1];
    I.xy -= p[1] * u[0];
    I.yz -= p[1] * u[2];
  }
  if constexpr (p[2] != 0) {
    I.xx += 2 * p[2] * u[2];
    I.yy += 2 * p[2] * u[2];
    I.xz -= p[2] * u[0];
    I.yz -= p[2] * u[1];
  }
  return shifted;
}

}  // namespace twin::model::internal
