#include "render/frame_parts.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace twin::render {
namespace {

constexpr const char* kFlange = "panda_link7";  ///< the flange is its end, 10.7 cm further

/// Gripper camera in panda_link7's frame (z along the flange's axis), m. It is beside the hand,
/// which is mounted at -45 degrees, away from the fingers; the finger tips are in the middle of its
/// picture.
constexpr double kMount = -0.70710678118654752;  ///< sine of that angle; its cosine is the negative
constexpr Vector3 kAside{-kMount, kMount, 0};
constexpr double kEyeAside = 0.09;
constexpr double kEyeAlong = 0.09;
constexpr Vector3 kAim{0, 0, 0.205};

Vector3 InWorld(const mjData& data, int body, const Vector3& p_B) {
  Vector3 p_W{};
  mju_mulMatVec(p_W.data(), data.xmat + std::ptrdiff_t{9} * body, p_B.data(), 3, 3);
  mju_addTo3(p_W.data(), data.xpos + std::ptrdiff_t{3} * body);
  return p_W;
}

/// The picture's up direction is the side of the mount.
CameraFrame GripperCamera(const mjData& data, int flange) {
  CameraFrame frame;
  frame.p_W = InWorld(data, flange, {kEyeAside * kAside[0], kEyeAside * kAside[1], kEyeAlong});
  const Vector3 aim = InWorld(data, flange, kAim);
  mju_sub3(frame.forward_W.data(), aim.data(), frame.p_W.data());
  mju_normalize3(frame.forward_W.data());
  mju_mulMatVec(frame.up_W.data(), data.xmat + std::ptrdiff_t{9} * flange, kAside.data(), 3, 3);
  const mjtNum along = mju_dot3(frame.up_W.data(), frame.forward_W.data());
  mju_addToScl3(frame.up_W.data(), frame.forward_W.data(), -along);
  mju_normalize3(frame.up_W.data());
  return frame;
}

/// @param R_WB  of the body, row-major as in MuJoCo.
void TurnAlong(const mjtNum* R_WB, mjvCamera& camera) {
  const double yaw = std::atan2(R_WB[3], R_WB[0]);
  const double x = camera.lookat[0];
  const double y = camera.lookat[1];
  camera.lookat[0] = std::cos(yaw) * x - std::sin(yaw) * y;
  camera.lookat[1] = std::sin(yaw) * x + std::cos(yaw) * y;
  camera.azimuth += yaw * 180 / std::numbers::pi;
}

}  // namespace

CameraRig::CameraRig(const View& view, const DrawnModel& model) : view_(view) {
  view_.Validate();
  if (view_.kind == ViewKind::kScene) id_ = model.CameraId(view_.name);
  if (view_.kind == ViewKind::kTracking) id_ = model.BodyId(view_.name);
  if (view_.kind == ViewKind::kGripper) id_ = model.BodyId(view_.name + kFlange);
}

void CameraRig::Aim(Duration since, const mjData& data, Shot& shot) const {
  mjv_defaultCamera(&shot.camera);
  shot.frame.reset();
  if (view_.kind == ViewKind::kScene) {
    shot.camera.type = mjCAMERA_FIXED;
    shot.camera.fixedcamid = id_;
    return;
  }
  shot.camera.type = mjCAMERA_FREE;
  if (view_.kind == ViewKind::kGripper) {
    shot.frame = GripperCamera(data, id_);
    return;
  }
  const FreeCamera& orbit = view_.orbit;
  shot.camera.distance = orbit.distance_m;
  shot.camera.elevation = orbit.elevation_deg;
  shot.camera.azimuth =
      std::fmod(orbit.azimuth_deg + view_.turn_deg_per_s * ToSeconds(since), 360.0);
  std::copy(orbit.lookat_m.begin(), orbit.lookat_m.end(), shot.camera.lookat);
  if (view_.kind != ViewKind::kTracking) return;
  if (view_.turns_along) TurnAlong(data.xmat + std::ptrdiff_t{9} * id_, shot.camera);
  mju_addTo3(shot.camera.lookat, data.xpos + std::ptrdiff_t{3} * id_);
}

}  // namespace twin::render
