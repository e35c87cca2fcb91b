#include "render/frame_parts.h"

namespace twin::render {
namespace {

/// Geoms drawn in addition to the model do not belong to it.
mjvGeom Begin(int type, const Vector3& size, const Vector3& p_W, const Colour& colour) {
  mjvGeom geom;
  mjv_initGeom(&geom, type, size.data(), p_W.data(), /*mat=*/nullptr, colour.data());
  geom.category = mjCAT_DECOR;
  return geom;
}

mjvGeom Between(int type, const Vector3& from, const Vector3& to, double width,
                const Colour& colour) {
  mjvGeom geom = Begin(type, {}, from, colour);
  mjv_makeConnector(&geom, type, width, from[0], from[1], from[2], to[0], to[1], to[2]);
  return geom;
}

}  // namespace

mjvGeom Ball(const Vector3& p_W, double radius, const Colour& colour) {
  return Begin(mjGEOM_SPHERE, {radius, radius, radius}, p_W, colour);
}

mjvGeom Rod(const Vector3& from_W, const Vector3& to_W, double radius, const Colour& colour) {
  return Between(mjGEOM_CAPSULE, from_W, to_W, radius, colour);
}

mjvGeom ForceArrow(const record::PointForce& force, double newton_m, const Colour& colour) {
  constexpr double kWidth = 0.008;  // m
  Vector3 tail{};
  for (std::size_t i = 0; i < 3; ++i) tail[i] = force.p_W[i] - newton_m * force.force_W[i];
  mjvGeom arrow = Between(mjGEOM_ARROW, tail, force.p_W, kWidth, colour);
  arrow.size[2] *= 2;  // a connector's size is half its length, an arrow's its full length
  return arrow;
}

}  // namespace twin::render
