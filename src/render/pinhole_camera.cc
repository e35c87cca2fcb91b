#include "twin/render/pinhole_camera.h"

#include <fmt/format.h>

#include <cmath>

#include "twin/core/error.h"

namespace twin::render {
namespace {

constexpr double kRadPerDeg = 3.14159265358979323846 / 180;

}  // namespace

void FreeCamera::Validate(std::string_view what) const {
  const auto field = [&](const char* name) { return fmt::format("render: {} {}", what, name); };
  RequireInRange(field("distance (m)"), distance_m, 0.01, 1000);
  RequireInRange(field("azimuth (degrees)"), azimuth_deg, -360, 360);
  RequireInRange(field("elevation (degrees)"), elevation_deg, -90, 90);
  for (const double x : lookat_m) RequireInRange(field("lookat (m)"), x, -1e3, 1e3);
}

PinholeCamera::PinholeCamera(const Transform& X_WC, double fovy_deg, int width, int height)
    : X_WC_(X_WC),
      focal_length_px_(0.5 * height / std::tan(0.5 * fovy_deg * kRadPerDeg)),
      principal_point_{0.5 * width, 0.5 * height} {}

PinholeCamera PinholeCamera::FromFreeCamera(const FreeCamera& camera, double fovy_deg, int width,
                                            int height) {
  const double a = camera.azimuth_deg * kRadPerDeg;
  const double e = camera.elevation_deg * kRadPerDeg;
  const Vector3 d{std::cos(e) * std::cos(a), std::cos(e) * std::sin(a), std::sin(e)};
  const Vector3& c = camera.lookat_m;
  const double r = camera.distance_m;
  // Columns: x to the right (horizontal), y up, z = -d; then the camera's position.
  const Transform X_WC{std::sin(a),
                       -std::cos(a),
                       0,
                       0,
                       -std::sin(e) * std::cos(a),
                       -std::sin(e) * std::sin(a),
                       std::cos(e),
                       0,
                       -d[0],
                       -d[1],
                       -d[2],
                       0,
                       c[0] - r * d[0],
                       c[1] - r * d[1],
                       c[2] - r * d[2],
                       1};
  return PinholeCamera(X_WC, fovy_deg, width, height);
}

std::optional<PixelPoint> PinholeCamera::Project(const Vector3& p_W) const noexcept {
  Vector3 p_C{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t i = 0; i < 3; ++i) p_C[axis] += X_WC_[4 * axis + i] * (p_W[i] - X_WC_[12 + i]);
  }
  const double depth = -p_C[2];
  if (!(depth > 0)) return std::nullopt;
  return PixelPoint{principal_point_.u + focal_length_px_ * p_C[0] / depth,
                    principal_point_.v - focal_length_px_ * p_C[1] / depth};
}

}  // namespace twin::render
