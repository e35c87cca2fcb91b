#include "twin/render/renderer.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <mujoco/mujoco.h>

#include <algorithm>
#include <cstddef>
#include <vector>

#include "render/mujoco_call.h"
#include "render/scene_renderer.h"
#include "twin/core/check.h"
#include "twin/core/error.h"

namespace twin::render {
namespace {

struct FreeModel {
  void operator()(mjModel* model) const noexcept { mj_deleteModel(model); }
};
struct FreeData {
  void operator()(mjData* data) const noexcept { mj_deleteData(data); }
};
using ModelPointer = std::unique_ptr<mjModel, FreeModel>;
using DataPointer = std::unique_ptr<mjData, FreeData>;

void CheckRange(const char* field, double value, double low, double high) {
  if (!(value >= low && value <= high)) {
    throw InputError(
        fmt::format("render: {} is {}; it must be in [{}, {}]", field, value, low, high));
  }
}

/// @returns the names of all objects of a kind, for messages.
std::string NamesOf(const mjModel& model, mjtObj type, int count) {
  std::vector<std::string> names;
  for (int i = 0; i < count; ++i) {
    const char* const name = mj_id2name(&model, type, i);
    if (name != nullptr) names.emplace_back(name);
  }
  return names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", "));
}

/// A copy of the model whose off-screen buffer fits the settings; MuJoCo reads these sizes when the
/// context is made.
ModelPointer CopyForRendering(const mjModel& model, const RenderSettings& settings) {
  ModelPointer copy(mj_copyModel(nullptr, &model));
  copy->vis.global.offwidth = settings.width;
  copy->vis.global.offheight = settings.height;
  copy->vis.quality.offsamples = settings.samples;
  copy->vis.quality.shadowsize = settings.shadows ? settings.shadow_size : 0;
  return copy;
}

mjvCamera MakeCamera(const mjModel& model, const RenderSettings& settings) {
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
  camera.fixedcamid = mj_name2id(&model, mjOBJ_CAMERA, settings.camera.c_str());
  if (camera.fixedcamid < 0) {
    throw InputError(fmt::format(
        "render: the model has no camera named \"{}\"; cameras it has: {}. Leave the name empty to "
        "use the free camera",
        settings.camera, NamesOf(model, mjOBJ_CAMERA, model.ncam)));
  }
  return camera;
}

}  // namespace

void RenderSettings::Validate() const {
  CheckRange("width (pixels)", width, 16, 4096);
  CheckRange("height (pixels)", height, 16, 4096);
  CheckRange("shadow_size (texels)", shadow_size, 128, 8192);
  CheckRange("free camera's distance (m)", free_camera.distance_m, 0.01, 1000);
  CheckRange("free camera's azimuth (degrees)", free_camera.azimuth_deg, -360, 360);
  CheckRange("free camera's elevation (degrees)", free_camera.elevation_deg, -90, 90);
  for (const double x : free_camera.lookat_m) CheckRange("free camera's lookat (m)", x, -1e3, 1e3);
  if (samples != 0 && samples != 2 && samples != 4) {
    throw InputError(fmt::format("render: samples is {}; it must be 0, 2 or 4", samples));
  }
}

class Renderer::Impl {
 public:
  Impl(const mjModel& model, const RenderSettings& settings)
      : settings_(settings),
        model_(CopyForRendering(model, settings)),
        data_(mj_makeData(model_.get())),
        camera_(MakeCamera(*model_, settings)),
        scene_(*model_, settings) {}

  Image Render(std::span<const double> qpos, std::string_view caption) {
    SetPositions(qpos);
    return scene_.Draw(*data_, camera_, std::string(caption));
  }

  Image Render(std::span<const double> qpos, const Ghost& ghost, std::string_view caption) {
    TWIN_CHECK(ghost.line.size() <= Ghost::kMostPoints);
    SetPositions(qpos);
    if (ghost.qpos.empty()) return scene_.Draw(*data_, camera_, std::string(caption), &ghost);
    const DataPointer elsewhere(mj_makeData(model_.get()));
    SetPositions(ghost.qpos, *elsewhere);
    return scene_.Draw(*data_, camera_, std::string(caption), &ghost, elsewhere.get());
  }

  [[nodiscard]] std::vector<double> WithArmAt(std::span<const double> qpos,
                                              const JointVector& q) const {
    TWIN_CHECK(qpos.size() == qpos_size());
    std::vector<double> moved(qpos.begin(), qpos.end());
    for (std::size_t i = 0; i < kJoints; ++i) {
      const std::string name = fmt::format("panda_joint{}", i + 1);
      const int joint = mj_name2id(model_.get(), mjOBJ_JOINT, name.c_str());
      if (joint < 0) throw InputError(fmt::format("render: the model has no joint {}", name));
      moved[static_cast<std::size_t>(model_->jnt_qposadr[joint])] = q[i];
    }
    return moved;
  }

  [[nodiscard]] std::vector<double> WithBodyAt(std::span<const double> qpos,
                                               const std::string& body,
                                               const Transform& X_WB) const {
    TWIN_CHECK(qpos.size() == qpos_size());
    const int id = mj_name2id(model_.get(), mjOBJ_BODY, body.c_str());
    const int joint = id < 0 ? -1 : model_->body_jntadr[id];
    if (joint < 0 || model_->jnt_type[joint] != mjJNT_FREE) {
      throw InputError(fmt::format("render: the model has no free body {}", body));
    }
    std::vector<double> moved(qpos.begin(), qpos.end());
    double* const pose = moved.data() + model_->jnt_qposadr[joint];
    std::copy_n(X_WB.begin() + 12, 3, pose);
    const std::array<mjtNum, 9> R{X_WB[0], X_WB[4], X_WB[8], X_WB[1], X_WB[5],
                                  X_WB[9], X_WB[2], X_WB[6], X_WB[10]};  // row-major
    mju_mat2Quat(pose + 3, R.data());
    return moved;
  }

  SegmentationImage Segment(std::span<const double> qpos, std::span<const int> only_bodies) {
    SetPositions(qpos);
    return scene_.Segment(*data_, camera_, only_bodies);
  }

  PinholeCamera Camera(std::span<const double> qpos) {
    if (camera_.type == mjCAMERA_FREE) {
      return PinholeCamera::FromFreeCamera(settings_.free_camera, model_->vis.global.fovy,
                                           settings_.width, settings_.height);
    }
    SetPositions(qpos);
    const auto id = static_cast<std::ptrdiff_t>(camera_.fixedcamid);
    const mjtNum* const R = data_->cam_xmat + 9 * id;  // row-major
    const mjtNum* const p = data_->cam_xpos + 3 * id;
    const Transform X_WC{R[0], R[3], R[6], 0, R[1], R[4], R[7], 0,
                         R[2], R[5], R[8], 0, p[0], p[1], p[2], 1};
    return PinholeCamera(X_WC, model_->cam_fovy[id], settings_.width, settings_.height);
  }

  [[nodiscard]] int BodyId(std::string_view name) const {
    const int id = mj_name2id(model_.get(), mjOBJ_BODY, std::string(name).c_str());
    if (id < 0) {
      throw InputError(fmt::format("render: the model has no body named \"{}\"; bodies it has: {}",
                                   name, NamesOf(*model_, mjOBJ_BODY, model_->nbody)));
    }
    return id;
  }

  [[nodiscard]] std::size_t qpos_size() const noexcept {
    return static_cast<std::size_t>(model_->nq);
  }
  [[nodiscard]] const RenderSettings& settings() const noexcept { return settings_; }

 private:
  void SetPositions(std::span<const double> qpos) { SetPositions(qpos, *data_); }

  /// Poses of bodies, geoms, lights and cameras at `qpos`; no dynamics.
  void SetPositions(std::span<const double> qpos, mjData& data) const {
    TWIN_CHECK(qpos.size() == qpos_size());
    std::copy(qpos.begin(), qpos.end(), data.qpos);
    mj_kinematics(model_.get(), &data);
    mj_comPos(model_.get(), &data);
    mj_camlight(model_.get(), &data);
  }

  RenderSettings settings_;
  ModelPointer model_;
  DataPointer data_;
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
  return MujocoCall("A frame cannot be drawn", [&] { return impl_->Render(qpos, caption); });
}

Image Renderer::Render(std::span<const double> qpos, const Ghost& ghost, std::string_view caption) {
  return MujocoCall("A frame cannot be drawn", [&] { return impl_->Render(qpos, ghost, caption); });
}

std::vector<double> Renderer::WithArmAt(std::span<const double> qpos, const JointVector& q) const {
  return impl_->WithArmAt(qpos, q);
}

std::vector<double> Renderer::WithBodyAt(std::span<const double> qpos, const std::string& body,
                                         const Transform& X_WB) const {
  return impl_->WithBodyAt(qpos, body, X_WB);
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
  return impl_->BodyId(name);
}

std::size_t Renderer::qpos_size() const noexcept {
  return impl_->qpos_size();
}

const RenderSettings& Renderer::settings() const noexcept {
  return impl_->settings();
}

}  // namespace twin::render
