#include "render/scene_renderer.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "twin/core/error.h"

namespace twin::render {
namespace {

/// Capacity for geoms beyond the model's: marks, and those that MuJoCo adds.
constexpr int kSpareGeoms = 1000 + static_cast<int>(Ghost::kMostPoints);

/// True if a geom has nearly the same pose in both: coinciding surfaces render as speckles, which
/// differ between rasterisers.
bool StandsAlike(const mjData& a, const mjData& b, int geom) {
  constexpr mjtNum kNear = 4e-3;     // m
  constexpr mjtNum kAligned = 0.02;  // of a rotation matrix: about a degree
  const auto alike = [&](const mjtNum* x, const mjtNum* y, std::ptrdiff_t count, mjtNum most) {
    return std::equal(x + geom * count, x + (geom + 1) * count, y + geom * count,
                      [most](mjtNum p, mjtNum q) { return std::abs(p - q) < most; });
  };
  return alike(a.geom_xpos, b.geom_xpos, 3, kNear) && alike(a.geom_xmat, b.geom_xmat, 9, kAligned);
}

/// Scale at which captions remain legible when the picture is halved.
int FontScale(int height) {
  if (height < 300) return mjFONTSCALE_100;
  return height < 700 ? mjFONTSCALE_150 : mjFONTSCALE_250;
}

void PutFrame(const CameraFrame& frame, mjvGLCamera& camera) {
  std::copy(frame.p_W.begin(), frame.p_W.end(), camera.pos);
  std::copy(frame.forward_W.begin(), frame.forward_W.end(), camera.forward);
  std::copy(frame.up_W.begin(), frame.up_W.end(), camera.up);
}

/// Flips rows: OpenGL's first row is the lowest.
template <class T>
void FlipRows(std::vector<T>& values, std::size_t row) {
  for (std::size_t top = 0, bottom = values.size(); top + row < bottom; top += row) {
    bottom -= row;
    std::swap_ranges(values.begin() + static_cast<std::ptrdiff_t>(top),
                     values.begin() + static_cast<std::ptrdiff_t>(top + row),
                     values.begin() + static_cast<std::ptrdiff_t>(bottom));
  }
}

}  // namespace

SceneRenderer::SceneRenderer(const mjModel& model, const RenderSettings& settings)
    : model_(model), settings_(settings) {
  mjv_defaultOption(&option_);
  mjv_defaultScene(&scene_);
  mjr_defaultContext(&context_);
  const Current current = Use();
  try {
    mjv_makeScene(&model_, &scene_, 2 * model_.ngeom + kSpareGeoms);
    mjr_makeContext(&model_, &context_, FontScale(settings_.height));
    mjr_setBuffer(mjFB_OFFSCREEN, &context_);
  } catch (...) {
    mjr_freeContext(&context_);
    mjv_freeScene(&scene_);
    throw;
  }
  scene_.flags[mjRND_REFLECTION] = settings_.reflections;
}

SceneRenderer::~SceneRenderer() {
  if (!OsMesaContext::LivesHere()) return;  // nothing of it can be freed
  const Current current = Use();
  mjr_freeContext(&context_);
  mjv_freeScene(&scene_);
}

void SceneRenderer::Draw(const Shot& shot, mjrRect viewport) {
  UpdateScene(shot);
  if (shot.elsewhere != nullptr) AddElsewhere(shot);
  TWIN_CHECK(static_cast<std::size_t>(scene_.maxgeom - scene_.ngeom) >= shot.marks.size());
  std::copy(shot.marks.begin(), shot.marks.end(), scene_.geoms + scene_.ngeom);
  scene_.ngeom += static_cast<int>(shot.marks.size());
  scene_.flags[mjRND_SEGMENT] = 0;
  scene_.flags[mjRND_IDCOLOR] = 0;
  scene_.flags[mjRND_SKYBOX] = 1;
  scene_.flags[mjRND_SHADOW] = settings_.shadows;
  mjr_render(viewport, &scene_, &context_);
}

void SceneRenderer::Write(int where, const std::string& text) {
  mjr_overlay(mjFONT_NORMAL, where, Whole(), text.c_str(), nullptr, &context_);
}

void SceneRenderer::Fill(mjrRect rectangle, const std::array<float, 4>& colour) const {
  mjr_rectangle(rectangle, colour[0], colour[1], colour[2], colour[3]);
}

Image SceneRenderer::Read() const {
  Image image(settings_.width, settings_.height);
  mjr_readPixels(image.rgb.data(), /*depth=*/nullptr, Whole(), &context_);
  FlipRows(image.rgb, 3 * static_cast<std::size_t>(image.width));
  return image;
}

/// The buffer holds z = (1/near - 1/d) / (1/near - 1/far).
DepthImage SceneRenderer::Measure(const Shot& shot) {
  UpdateScene(shot);
  scene_.flags[mjRND_SEGMENT] = 0;
  scene_.flags[mjRND_IDCOLOR] = 0;
  scene_.flags[mjRND_SKYBOX] = 0;
  scene_.flags[mjRND_SHADOW] = 0;
  mjr_render(Whole(), &scene_, &context_);
  DepthImage image{settings_.width, settings_.height, {}};
  image.depth_m.resize(static_cast<std::size_t>(image.width) *
                       static_cast<std::size_t>(image.height));
  mjr_readPixels(/*rgb=*/nullptr, image.depth_m.data(), Whole(), &context_);
  FlipRows(image.depth_m, static_cast<std::size_t>(image.width));
  const double near_m = model_.vis.map.znear * model_.stat.extent;
  const double far_m = model_.vis.map.zfar * model_.stat.extent;
  for (float& z : image.depth_m) {
    const double nearness = 1 / near_m - z * (1 / near_m - 1 / far_m);
    z = z >= 1 ? DepthImage::kBackground : static_cast<float>(1 / nearness);
  }
  return image;
}

SegmentationImage SceneRenderer::Segment(const Shot& shot, std::span<const int> only_bodies) {
  UpdateScene(shot);
  if (!only_bodies.empty()) KeepBodies(only_bodies);
  scene_.flags[mjRND_SEGMENT] = 1;
  scene_.flags[mjRND_IDCOLOR] = 1;
  scene_.flags[mjRND_SKYBOX] = 0;
  scene_.flags[mjRND_SHADOW] = 0;
  mjr_render(Whole(), &scene_, &context_);
  const std::vector<std::int32_t> bodies = BodiesByColour();
  const Image colours = Read();
  SegmentationImage out{colours.width, colours.height, {}};
  out.body.reserve(colours.Pixels());
  for (std::size_t i = 0; i < colours.rgb.size(); i += 3) {
    const std::size_t id =
        colours.rgb[i] | (colours.rgb[i + 1] << 8U) | (colours.rgb[i + 2] << 16U);
    out.body.push_back(id < bodies.size() ? bodies[id] : SegmentationImage::kBackground);
  }
  return out;
}

std::vector<std::int32_t> SceneRenderer::BodiesByColour() const {
  std::vector<std::int32_t> bodies(static_cast<std::size_t>(scene_.ngeom) + 1,
                                   SegmentationImage::kBackground);
  for (int i = 0; i < scene_.ngeom; ++i) {
    const mjvGeom& geom = scene_.geoms[i];
    if (geom.segid < 0 || geom.objtype != mjOBJ_GEOM) continue;
    const auto colour = static_cast<std::size_t>(geom.segid) + 1;
    if (colour >= bodies.size()) bodies.resize(colour + 1, SegmentationImage::kBackground);
    bodies[colour] = model_.geom_bodyid[geom.objid];
  }
  return bodies;
}

void SceneRenderer::UpdateScene(const Shot& shot) {
  mjvCamera camera = shot.camera;
  mjv_updateScene(&model_, shot.data, &option_, /*pert=*/nullptr, &camera, mjCAT_ALL, &scene_);
  if (!shot.frame) return;
  for (mjvGLCamera& eye : scene_.camera) PutFrame(*shot.frame, eye);
}

void SceneRenderer::AddElsewhere(const Shot& shot) {
  const int real = scene_.ngeom;
  mjv_addGeoms(&model_, shot.elsewhere, &option_, /*pert=*/nullptr, mjCAT_DYNAMIC, &scene_);
  mjvGeom* const end =
      std::remove_if(scene_.geoms + real, scene_.geoms + scene_.ngeom, [&](const mjvGeom& geom) {
        return geom.objtype != mjOBJ_GEOM || StandsAlike(*shot.data, *shot.elsewhere, geom.objid);
      });
  scene_.ngeom = static_cast<int>(end - scene_.geoms);
  for (int i = real; i < scene_.ngeom; ++i) {
    mjvGeom& geom = scene_.geoms[i];
    std::copy(shot.elsewhere_colour.begin(), shot.elsewhere_colour.end(), geom.rgba);
    geom.texid = -1;
  }
}

void SceneRenderer::KeepBodies(std::span<const int> bodies) {
  mjvGeom* const end =
      std::remove_if(scene_.geoms, scene_.geoms + scene_.ngeom, [&](const mjvGeom& geom) {
        return geom.objtype != mjOBJ_GEOM ||
               std::find(bodies.begin(), bodies.end(), model_.geom_bodyid[geom.objid]) ==
                   bodies.end();
      });
  scene_.ngeom = static_cast<int>(end - scene_.geoms);
}

}  // namespace twin::render
