#include "twin/render/renderer.h"

#include <mujoco/mujoco.h>

#include <algorithm>
#include <cstddef>
#include <vector>

#include <fmt/format.h>

#include "render/drawn_model.h"
#include "render/frame_parts.h"
#include "render/scene_renderer.h"
#include "twin/core/error.h"

namespace twin::render {
namespace {

mjvCamera MakeCamera(const DrawnModel& model, const RenderSettings& settings) {
  mjvCamera camera;
  mjv_defaultCamera(&camera);
  if (settings.camera.empty()) {
    const FreeCamera& free = settings.free_camera;
    camera.type = mjCAMERA_FREE;
    std::copy(free.lookat_m.begin(), free.lookat_m.end(), camera.lookat);
    camera.distance = free.distance_m;
    camera.azimuth = free.azimuth_deg;
    camera.elevation = free.elevation_deg;
    return camera;
  }
  camera.type = mjCAMERA_FIXED;
  camera.fixedcamid = model.CameraId(settings.camera);
  return camera;
}

/// The line of a ghost, as balls, so that its bends are round.
std::vector<mjvGeom> LineOf(const Ghost& ghost) {
  std::vector<mjvGeom> line;
  line.reserve(ghost.line.size());
  for (const Vector3& point : ghost.line) {
    line.push_back(Ball(point, ghost.radius, ghost.line_colour));
  }
  return line;
}

}  // namespace

void RenderSettings::Validate() const {
  RequireInRange("render: width (pixels)", width, 16, 4096);
  RequireInRange("render: height (pixels)", height, 16, 4096);
  RequireInRange("render: shadow_size (texels)", shadow_size, 128, 8192);
  free_camera.Validate("free camera's");
  if (samples != 0 && samples != 2 && samples != 4) {
    throw InputError(fmt::format("render: samples is {}; it must be 0, 2 or 4", samples));
  }
}

class Renderer::Impl {
 public:
  Impl(const mjModel& model, const RenderSettings& settings)
      : settings_(settings),
        model_(model, settings),
        data_(model_.NewData()),
        camera_(MakeCamera(model_, settings)),
        scene_(model_.get(), settings) {}

  Image Render(std::span<const double> qpos, const Ghost& ghost, std::string_view caption) {
    TWIN_CHECK(ghost.line.size() <= Ghost::kMostPoints);
    Shot shot = ShotAt(qpos);
    DrawnModel::DataPointer elsewhere;
    if (!ghost.qpos.empty()) {
      elsewhere = model_.NewData();
      model_.SetPositions(ghost.qpos, *elsewhere);
      shot.elsewhere = elsewhere.get();
      shot.elsewhere_colour = ghost.colour;
    }
    const std::vector<mjvGeom> line = LineOf(ghost);
    shot.marks = line;
    const SceneRenderer::Current current = scene_.Use();
    scene_.Draw(shot, scene_.Whole());
    if (!caption.empty()) scene_.Write(mjGRID_BOTTOMLEFT, std::string(caption));
    return scene_.Read();
  }

  SegmentationImage Segment(std::span<const double> qpos, std::span<const int> only_bodies) {
    const SceneRenderer::Current current = scene_.Use();
    return scene_.Segment(ShotAt(qpos), only_bodies);
  }

  PinholeCamera Camera(std::span<const double> qpos) {
    if (camera_.type == mjCAMERA_FREE) {
      return PinholeCamera::FromFreeCamera(settings_.free_camera, model_.get().vis.global.fovy,
                                           settings_.width, settings_.height);
    }
    model_.SetPositions(qpos, *data_);
    const auto id = static_cast<std::ptrdiff_t>(camera_.fixedcamid);
    return PinholeCamera(CameraPose(*data_, id), model_.get().cam_fovy[id], settings_.width,
                         settings_.height);
  }

  [[nodiscard]] const DrawnModel& model() const noexcept { return model_; }
  [[nodiscard]] const RenderSettings& settings() const noexcept { return settings_; }

 private:
  Shot ShotAt(std::span<const double> qpos) {
    model_.SetPositions(qpos, *data_);
    Shot shot;
    shot.data = data_.get();
    shot.camera = camera_;
    return shot;
  }

  RenderSettings settings_;
  DrawnModel model_;
  DrawnModel::DataPointer data_;
  mjvCamera camera_;
  SceneRenderer scene_;
};

Renderer::Renderer(const mjModel_& model, const RenderSettings& settings) {
  settings.Validate();
  impl_ = MujocoCall(
      "The off-screen renderer cannot start (it needs Debian's libosmesa6, and no "
      "libEGL or libGL in the process)",
      [&] { return std::make_unique<Impl>(model, settings); });
}

Renderer::~Renderer() = default;
Renderer::Renderer(Renderer&&) noexcept = default;

Image Renderer::Render(std::span<const double> qpos, std::string_view caption) {
  return MujocoCall("A frame cannot be drawn", [&] { return impl_->Render(qpos, {}, caption); });
}

Image Renderer::Render(std::span<const double> qpos, const Ghost& ghost, std::string_view caption) {
  return MujocoCall("A frame cannot be drawn", [&] { return impl_->Render(qpos, ghost, caption); });
}

std::vector<double> Renderer::WithArmAt(std::span<const double> qpos, const JointVector& q) const {
  return impl_->model().WithArmAt(qpos, q);
}

std::vector<double> Renderer::WithBodyAt(std::span<const double> qpos, const std::string& body,
                                         const Transform& X_WB) const {
  return impl_->model().WithBodyAt(qpos, body, X_WB);
}

SegmentationImage Renderer::Segment(std::span<const double> qpos,
                                    std::span<const int> only_bodies) {
  return MujocoCall("A segmentation cannot be drawn",
                    [&] { return impl_->Segment(qpos, only_bodies); });
}

PinholeCamera Renderer::Camera(std::span<const double> qpos) {
  return impl_->Camera(qpos);
}

int Renderer::BodyId(std::string_view name) const {
  return impl_->model().BodyId(name);
}

std::size_t Renderer::qpos_size() const noexcept {
  return impl_->model().qpos_size();
}

const RenderSettings& Renderer::settings() const noexcept {
  return impl_->settings();
}

std::vector<std::string> BodyNames(const mjModel_& model) {
  std::vector<std::string> names;
  for (int body = 0; body < model.nbody; ++body) {
    const char* name = mj_id2name(&model, mjOBJ_BODY, body);
    names.push_back(name == nullptr || *name == 0 ? fmt::format("body {}", body) : name);
  }
  return names;
}

}  // namespace twin::render
