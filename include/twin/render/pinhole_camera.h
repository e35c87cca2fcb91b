#pragma once

#include <optional>
#include <string_view>

#include "twin/core/joint_vector.h"

namespace twin::render {

/// A point in continuous pixels: (0, 0) is the outer corner of the top left pixel, whose centre is
/// (0.5, 0.5); u points right, v down.
struct PixelPoint {
  double u = 0;
  double v = 0;
};

/// A camera that orbits a point in the world.
///
/// It looks along d = (cos e cos a, cos e sin a, sin e) from lookat_m - distance_m * d, upright:
/// azimuth 180 looks along -x of the world, and a negative elevation looks down.
struct FreeCamera {
  double azimuth_deg = 142;
  double elevation_deg = -16;
  double distance_m = 1.95;
  Vector3 lookat_m = {0.12, 0, 0.52};  ///< in the world

  /// @param what  name in messages. @throws InputError naming field, value and range.
  void Validate(std::string_view what) const;
};

/// An ideal camera: no distortion, square pixels, principal point at the centre of the picture.
///
/// With p_C the point in the camera frame C (x right, y up, z backwards, as in MuJoCo and OpenGL),
/// f = height / (2 tan(fovy / 2)):
///   u = width / 2 + f x / -z,   v = height / 2 - f y / -z.
/// This projection is independent of the renderer's, so that each can check the other.
class PinholeCamera {
 public:
  /// @param X_WC  pose of the camera frame C in the world W.
  /// @param fovy_deg  vertical field of view, in (0, 180).
  /// @param width,height  of the picture, pixels.
  PinholeCamera(const Transform& X_WC, double fovy_deg, int width, int height);

  /// The pinhole camera equivalent to `camera`.
  [[nodiscard]] static PinholeCamera FromFreeCamera(const FreeCamera& camera, double fovy_deg,
                                                    int width, int height);

  /// @param p_W  a point in the world, m.
  /// @returns its pixel, which may be outside the frame; nullopt for a point behind the camera.
  [[nodiscard]] std::optional<PixelPoint> Project(const Vector3& p_W) const noexcept;

  [[nodiscard]] const Transform& X_WC() const noexcept { return X_WC_; }
  /// @returns f, pixels.
  [[nodiscard]] double focal_length_px() const noexcept { return focal_length_px_; }

 private:
  Transform X_WC_;
  double focal_length_px_;
  PixelPoint principal_point_;
};

}  // namespace twin::render
