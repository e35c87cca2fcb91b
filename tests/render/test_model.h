#pragma once

#include <mujoco/mujoco.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "twin/plant/truth_probe.h"

namespace twin::render {

/// A model compiled from MJCF text, and data at its initial state.
class TestModel final : public plant::TruthProbe {
 public:
  explicit TestModel(std::string_view mjcf) {
    const auto vfs = std::make_unique<mjVFS>();
    mj_defaultVFS(vfs.get());
    mj_makeEmptyFileVFS(vfs.get(), "model.xml", static_cast<int>(mjcf.size()));
    mjcf.copy(static_cast<char*>(vfs->filedata[0]), mjcf.size());
    char error[500] = "";
    model_.reset(mj_loadXML("model.xml", vfs.get(), error, sizeof error));
    mj_deleteVFS(vfs.get());
    if (!model_) throw std::runtime_error(error);
    data_.reset(mj_makeData(model_.get()));
  }

  [[nodiscard]] const mjModel_& model() const noexcept override { return *model_; }
  [[nodiscard]] const mjData_& data() const noexcept override { return *data_; }
  [[nodiscard]] std::size_t qpos_size() const noexcept override {
    return static_cast<std::size_t>(model_->nq);
  }
  void CopyQpos(std::span<double> out) const noexcept override {
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = data_->qpos[i];
  }
  [[nodiscard]] const std::string& prefix() const noexcept override { return prefix_; }
  [[nodiscard]] std::vector<double> Qpos() const { return {data_->qpos, data_->qpos + model_->nq}; }
  void SetQpos(std::size_t i, double value) { data_->qpos[i] = value; }
  void Step() { mj_step(model_.get(), data_.get()); }
  /// Applies a wrench [f; m] at a body's centre of mass, world axes.
  void Push(int body, const std::array<double, 6>& wrench) {
    mj_forward(model_.get(), data_.get());
    std::copy(wrench.begin(), wrench.end(), data_->xfrc_applied + std::ptrdiff_t{6} * body);
  }

 private:
  struct Free {
    void operator()(mjModel* model) const { mj_deleteModel(model); }
    void operator()(mjData* data) const { mj_deleteData(data); }
  };
  std::string prefix_;
  std::unique_ptr<mjModel, Free> model_;
  std::unique_ptr<mjData, Free> data_;
};

/// An arm of two capsules over a floor, lit from above, with a camera in the world ("side") and one
/// on the upper link ("wrist").
inline constexpr std::string_view kArmMjcf = R"(
<mujoco>
  <visual><headlight ambient="0.3 0.3 0.3"/></visual>
  <asset>
    <texture type="skybox" builtin="gradient" rgb1="0.8 0.9 1" rgb2="0.3 0.4 0.5" width="64"
             height="384"/>
  </asset>
  <worldbody>
    <light pos="1 -1 3" dir="-0.3 0.3 -1" directional="true"/>
    <camera name="side" pos="0 -2 0.5" xyaxes="1 0 0 0 0 1" fovy="50"/>
    <geom name="floor" type="plane" size="3 3 0.1" rgba="0.6 0.6 0.6 1"/>
    <body name="lower" pos="0 0 0.1">
      <joint name="a" axis="0 1 0"/>
      <geom type="capsule" fromto="0 0 0 0 0 0.4" size="0.05" rgba="0.9 0.9 0.9 1"/>
      <body name="upper" pos="0 0 0.4">
        <joint name="b" axis="0 1 0"/>
        <geom type="capsule" fromto="0 0 0 0.3 0 0" size="0.04" rgba="0.2 0.4 0.9 1"/>
        <geom name="hull" group="3" type="sphere" size="0.5"/>
        <camera name="wrist" pos="0.3 0 0.2" xyaxes="0 -1 0 1 0 1"/>
      </body>
    </body>
  </worldbody>
</mujoco>)";

}  // namespace twin::render
