#pragma once

#include <array>
#include <cstddef>
#include <utility>

#include "model/vector3.h"
#include "twin/core/joint_vector.h"

// Geometry of the arm at compile time: all twist angles are 0 or +-90 degrees and most lengths are
// zero, so a rotation about x swaps components and terms vanish.
namespace twin::model::internal {

/// One row of the modified DH table: T(i-1 -> i) = Rot_x(alpha) Trans_x(a) Rot_z(q) Trans_z(d).
struct DhRow {
  double a;
  double d;
  int sin_alpha;  ///< -1, 0 or 1: alpha = -90, 0 or 90 degrees
};

/// Source: Franka Control Interface documentation, Denavit-Hartenberg parameters of Panda.
inline constexpr std::array<DhRow, kJoints> kDh{{{0, 0.333, 0},
                                                 {0, 0, -1},
                                                 {0, 0.316, 1},
                                                 {0.0825, 0, 1},
                                                 {-0.0825, 0.384, -1},
                                                 {0, 0, 1},
                                                 {0.088, 0, 1}}};

/// The flange is frame 7, shifted along its z axis.
inline constexpr double kFlangeOffset = 0.107;

/// Origin of joint frame i in frame i - 1; i counts from 0, frame -1 is the base.
constexpr Vector3 Offset(std::size_t i) noexcept {
  switch (kDh[i].sin_alpha) {
    case 0: return {kDh[i].a, 0, kDh[i].d};
    case 1: return {kDh[i].a, -kDh[i].d, 0};
    default: return {kDh[i].a, kDh[i].d, 0};
  }
}

/// Rot_x(alpha_i) v.
template <std::size_t i>
constexpr Vector3 TiltToParent(const Vector3& v) noexcept {
  if constexpr (kDh[i].sin_alpha == 0) return v;
  if constexpr (kDh[i].sin_alpha == 1) return {v[0], -v[2], v[1]};
  if constexpr (kDh[i].sin_alpha == -1) return {v[0], v[2], -v[1]};
}

/// Rot_x(alpha_i)^T v.
template <std::size_t i>
constexpr Vector3 TiltToChild(const Vector3& v) noexcept {
  if constexpr (kDh[i].sin_alpha == 0) return v;
  if constexpr (kDh[i].sin_alpha == 1) return {v[0], v[2], -v[1]};
  if constexpr (kDh[i].sin_alpha == -1) return {v[0], -v[2], v[1]};
}

/// A vector of frame i in the axes of frame i - 1; s and c are sine and cosine of q_i.
template <std::size_t i>
constexpr Vector3 ToParent(const Vector3& v, double s, double c) noexcept {
  return TiltToParent<i>({c * v[0] - s * v[1], s * v[0] + c * v[1], v[2]});
}

/// A vector of frame i - 1 in the axes of frame i.
template <std::size_t i>
constexpr Vector3 ToChild(const Vector3& v, double s, double c) noexcept {
  const Vector3 t = TiltToChild<i>(v);
  return {c * t[0] + s * t[1], c * t[1] - s * t[0], t[2]};
}

/// p[row] f[column] - p[column] f[row] for p = Offset(i), without zero terms.
template <std::size_t i, std::size_t row, std::size_t column>
constexpr double OffsetMinor(const Vector3& f) noexcept {
  constexpr Vector3 p = Offset(i);
  if constexpr (p[row] != 0 && p[column] != 0) return p[row] * f[column] - p[column] * f[row];
  if constexpr (p[row] != 0 && p[column] == 0) return p[row] * f[column];
  if constexpr (p[row] == 0 && p[column] != 0) return -p[column] * f[row];
  return 0;
}

/// Offset(i) x f.
template <std::size_t i>
constexpr Vector3 OffsetCross(const Vector3& f) noexcept {
  return {OffsetMinor<i, 1, 2>(f), OffsetMinor<i, 2, 0>(f), OffsetMinor<i, 0, 1>(f)};
}

/// Calls f.operator()<i>() for i = 0, 1, ... 6.
template <typename F>
constexpr void BaseToTip(F&& f) noexcept {
  [&]<std::size_t... i>(std::index_sequence<i...>) {
    (f.template operator()<i>(), ...);
  }
  (std::make_index_sequence<kJoints>{});
}

/// Calls f.operator()<i>() for i = 6, 5, ... 0.
template <typename F>
constexpr void TipToBase(F&& f) noexcept {
  [&]<std::size_t... i>(std::index_sequence<i...>) {
    (f.template operator()<kJoints - 1 - i>(), ...);
  }
  (std::make_index_sequence<kJoints>{});
}

}  // namespace twin::model::internal
