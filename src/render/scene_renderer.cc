#include "render/scene_renderer.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <mutex>
#include <vector>

namespace twin::render {
namespace {

/// Room for what is drawn beside the model's geoms.
constexpr int kSpareGeoms = 200 + static_cast<int>(Ghost::kMostPoints);

/// MuJoCo keeps its table of OpenGL functions in globals, filled when a context is made.
std::mutex& LoaderMutex() {
  static std::mutex mutex;
  return mutex;
}

/// Makes a context current for the life of this object.
class CurrentContext {
 public:
  explicit CurrentContext(OsMesaContext& gl) { gl.MakeCurrent(); }
  ~CurrentContext() { OsMesaContext::ReleaseCurrent(); }
  CurrentContext(const CurrentContext&) = delete;
  CurrentContext& operator=(const CurrentContext&) = delete;
};

/// Whether a geom has the same pose in both.
bool StandsAlike(const mjData& a, const mjData& b, int geom) {
  constexpr mjtNum kAlike = 1e-6;
  const auto alike = [&](const mjtNum* x, const mjtNum* y, std::ptrdiff_t count) {
    return std::equal(x + geom * count, x + (geom + 1) * count, y + geom * count,
                      [](mjtNum p, mjtNum q) { return std::abs(p - q) < kAlike; });
  };
  return alike(a.geom_xpos, b.geom_xpos, 3) && alike(a.geom_xmat, b.geom_xmat, 9);
}

/// Captions that can still be read when the picture is halved.
int FontScale(int height) {
  if (height < 300) return mjFONTSCALE_100;
  return height < 700 ? mjFONTSCALE_150 : mjFONTSCALE_250;
}

}  // namespace

SceneRenderer::SceneRenderer(const mjModel& model, const RenderSettings& settings)
    : model_(model), settings_(settings) {
  mjv_defaultOption(&option_);
  mjv_defaultScene(&scene_);
  mjr_defaultContext(&context_);
  const CurrentContext current(gl_);
  try {
    mjv_makeScene(&model_, &scene_, 2 * model_.ngeom + kSpareGeoms);
    const std::lock_guard lock(LoaderMutex());
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
  const CurrentContext current(gl_);
  mjr_freeContext(&context_);
  mjv_freeScene(&scene_);
}

Image SceneRenderer::Draw(mjData& data, mjvCamera camera, const std::string& caption,
                          const Ghost* ghost, mjData* elsewhere) {
  const CurrentContext current(gl_);
  UpdateScene(data, camera);
  if (elsewhere != nullptr) AddElsewhere(data, *elsewhere, ghost->colour);
  if (ghost != nullptr) AddLine(*ghost);
  scene_.flags[mjRND_SEGMENT] = 0;
  scene_.flags[mjRND_IDCOLOR] = 0;
  scene_.flags[mjRND_SKYBOX] = 1;
  scene_.flags[mjRND_SHADOW] = settings_.shadows;
  mjr_render(Viewport(), &scene_, &context_);
  if (!caption.empty()) {
    mjr_overlay(mjFONT_NORMAL, mjGRID_BOTTOMLEFT, Viewport(), caption.c_str(), nullptr, &context_);
  }
  return ReadPixels();
}

SegmentationImage SceneRenderer::Segment(mjData& data, mjvCamera camera,
                                         std::span<const int> only_bodies) {
  const CurrentContext current(gl_);
  UpdateScene(data, camera);
  if (!only_bodies.empty()) KeepBodies(only_bodies);
  scene_.flags[mjRND_SEGMENT] = 1;
  scene_.flags[mjRND_IDCOLOR] = 1;
  scene_.flags[mjRND_SKYBOX] = 0;
  scene_.flags[mjRND_SHADOW] = 0;
  mjr_render(Viewport(), &scene_, &context_);

  std::vector<std::int32_t> bodies(static_cast<std::size_t>(scene_.ngeom) + 1,
                                   SegmentationImage::kBackground);
  for (int i = 0; i < scene_.ngeom; ++i) {
    const mjvGeom& geom = scene_.geoms[i];
    if (geom.segid < 0 || geom.objtype != mjOBJ_GEOM) continue;
    const auto colour = static_cast<std::size_t>(geom.segid) + 1;
    if (colour >= bodies.size()) bodies.resize(colour + 1, SegmentationImage::kBackground);
    bodies[colour] = model_.geom_bodyid[geom.objid];
  }
  const Image colours = ReadPixels();
  SegmentationImage out{colours.width, colours.height, {}};
  out.body.reserve(colours.Pixels());
  for (int row = 0; row < colours.height; ++row) {
    for (int column = 0; column < colours.width; ++column) {
      out.body.push_back(BodyOfColour(colours.at(column, row), bodies));
    }
  }
  return out;
}

void SceneRenderer::UpdateScene(mjData& data, mjvCamera& camera) {
  mjv_updateScene(&model_, &data, &option_, /*pert=*/nullptr, &camera, mjCAT_ALL, &scene_);
}

void SceneRenderer::AddElsewhere(const mjData& data, mjData& elsewhere,
                                 const std::array<float, 4>& colour) {
  const int real = scene_.ngeom;
  mjv_addGeoms(&model_, &elsewhere, &option_, /*pert=*/nullptr, mjCAT_DYNAMIC, &scene_);
  mjvGeom* const end =
      std::remove_if(scene_.geoms + real, scene_.geoms + scene_.ngeom, [&](const mjvGeom& geom) {
        return geom.objtype != mjOBJ_GEOM || StandsAlike(data, elsewhere, geom.objid);
      });
  scene_.ngeom = static_cast<int>(end - scene_.geoms);
  for (int i = real; i < scene_.ngeom; ++i) {
    mjvGeom& geom = scene_.geoms[i];
    std::copy(colour.begin(), colour.end(), geom.rgba);
    geom.texid = -1;
  }
}

void SceneRenderer::AddLine(const Ghost& ghost) {
  const mjtNum size[3] = {ghost.radius, 0, 0};
  for (const Vector3& point : ghost.line) {
    mjvGeom& geom = scene_.geoms[scene_.ngeom++];
    mjv_initGeom(&geom, mjGEOM_SPHERE, size, point.data(), /*mat=*/nullptr,
                 ghost.line_colour.data());
    geom.category = mjCAT_DECOR;
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

Image SceneRenderer::ReadPixels() const {
  Image image(settings_.width, settings_.height);
  mjr_readPixels(image.rgb.data(), /*depth=*/nullptr, Viewport(), &context_);
  for (int top = 0, bottom = image.height - 1; top < bottom; ++top, --bottom) {
    const auto upper = image.Row(top);
    std::swap_ranges(upper.begin(), upper.end(), image.Row(bottom).begin());
  }
  return image;
}

mjrRect SceneRenderer::Viewport() const noexcept {
  return {0, 0, settings_.width, settings_.height};
}

std::int32_t SceneRenderer::BodyOfColour(Rgb colour, std::span<const std::int32_t> bodies) const {
  const std::size_t id = colour[0] | (colour[1] << 8U) | (colour[2] << 16U);
  return id < bodies.size() ? bodies[id] : SegmentationImage::kBackground;
}

}  // namespace twin::render
