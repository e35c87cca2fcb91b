#include "plant/tyre.h"

#include <cmath>
#include <cstddef>

#include "twin/core/time.h"

namespace twin::plant {
namespace {

double Dot(const Vector3& a, const Vector3& b) noexcept {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// Component of `v` perpendicular to `normal`.
Vector3 Across(const Vector3& v, const Vector3& normal) noexcept {
  const double along = Dot(v, normal);
  return {v[0] - along * normal[0], v[1] - along * normal[1], v[2] - along * normal[2]};
}

}  // namespace

Vector3 Tyre::Step(const WheelLoad& load, const Vector3& slip, double rolling) noexcept {
  if (load.force <= 0) {
    Reset();
    return {};
  }
  const Vector3 v = Across(slip, load.normal);
  bend_ = Across(bend_, load.normal);
  Vector3 f{};
  for (std::size_t i = 0; i < 3; ++i) {
    bend_[i] += kCycleSeconds * (v[i] - rolling / kRelaxation * bend_[i]);
    f[i] = -(kStiffness * bend_[i] + kDamping * v[i]);
  }
  const double size = std::sqrt(Dot(f, f));
  const double most = kFriction * load.force;
  if (size <= most) return f;
  for (std::size_t i = 0; i < 3; ++i) {
    f[i] *= most / size;
    bend_[i] = -f[i] / kStiffness;
  }
  return f;
}

}  // namespace twin::plant
