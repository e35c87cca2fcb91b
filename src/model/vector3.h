#pragma once

#include "twin/core/joint_vector.h"

// Arithmetic of three-vectors for the recursions.
namespace twin::model::internal {

constexpr Vector3 operator+(const Vector3& a, const Vector3& b) noexcept {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}

constexpr Vector3 operator-(const Vector3& a, const Vector3& b) noexcept {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

constexpr Vector3 operator-(const Vector3& a) noexcept {
  return {-a[0], -a[1], -a[2]};
}

constexpr Vector3 operator*(double k, const Vector3& a) noexcept {
  return {k * a[0], k * a[1], k * a[2]};
}

constexpr Vector3 Cross(const Vector3& a, const Vector3& b) noexcept {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

constexpr double Dot(const Vector3& a, const Vector3& b) noexcept {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

}  // namespace twin::model::internal
