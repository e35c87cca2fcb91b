#pragma once

#include <mujoco/mujoco.h>

#include <array>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "twin/core/error.h"
#include "twin/core/joint_vector.h"
#include "twin/plant/engine.h"
#include "twin/render/renderer.h"

namespace twin::render {

/// Runs `call`; a MuJoCo error becomes an EnvironmentError that begins with `what`.
template <typename Call>
decltype(auto) MujocoCall(const char* what, Call&& call) {
  plant::InstallEngineHandlers();
  try {
    return std::forward<Call>(call)();
  } catch (const plant::EngineFault& fault) {
    throw EnvironmentError(std::string(what) + ": MuJoCo says \"" + fault.what() + "\"");
  }
}

/// A model's copy for rendering, and its positions.
///
/// Threads: immutable after construction; data as MuJoCo's.
class DrawnModel {
 public:
  struct FreeData {
    void operator()(mjData* data) const noexcept { mj_deleteData(data); }
  };
  using DataPointer = std::unique_ptr<mjData, FreeData>;

  /// Sizes the off-screen buffer by the settings; MuJoCo reads these sizes when it creates the
  /// context.
  DrawnModel(const mjModel& model, const RenderSettings& settings);

  [[nodiscard]] const mjModel& get() const noexcept { return *model_; }
  [[nodiscard]] std::size_t qpos_size() const noexcept {
    return static_cast<std::size_t>(model_->nq);
  }
  [[nodiscard]] DataPointer NewData() const { return DataPointer(mj_makeData(model_.get())); }

  /// Poses of bodies, geoms, lights and cameras at `qpos`; no dynamics.
  void SetPositions(std::span<const double> qpos, mjData& data) const;

  /// As Renderer::WithArmAt().
  [[nodiscard]] std::vector<double> WithArmAt(std::span<const double> qpos,
                                              const JointVector& q) const;
  [[nodiscard]] std::vector<double> WithBodyAt(std::span<const double> qpos,
                                               const std::string& body,
                                               const Transform& X_WB) const;
  [[nodiscard]] int BodyId(std::string_view name) const;
  [[nodiscard]] int CameraId(const std::string& name) const;
  /// Ids of the arm's joints. @throws InputError if the model has none.
  [[nodiscard]] std::array<int, kJoints> ArmJoints() const;

 private:
  struct FreeModel {
    void operator()(mjModel* model) const noexcept { mj_deleteModel(model); }
  };
  std::unique_ptr<mjModel, FreeModel> model_;
};

}  // namespace twin::render
