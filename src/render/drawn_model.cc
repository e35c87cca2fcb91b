#include "render/drawn_model.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstddef>

#include "twin/core/error.h"

namespace twin::render {
namespace {

/// @returns the names of all objects of a kind, for messages.
std::string NamesOf(const mjModel& model, mjtObj type, int count) {
  std::vector<std::string> names;
  for (int i = 0; i < count; ++i) {
    const char* const name = mj_id2name(&model, type, i);
    if (name != nullptr) names.emplace_back(name);
  }
  return names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", "));
}

}  // namespace

DrawnModel::DrawnModel(const mjModel& model, const RenderSettings& settings)
    : model_(mj_copyModel(nullptr, &model)) {
  model_->vis.global.offwidth = settings.width;
  model_->vis.global.offheight = settings.height;
  model_->vis.quality.offsamples = settings.samples;
  model_->vis.quality.shadowsize = settings.shadows ? settings.shadow_size : 0;
}

void DrawnModel::SetPositions(std::span<const double> qpos, mjData& data) const {
  TWIN_CHECK(qpos.size() == qpos_size());
  std::copy(qpos.begin(), qpos.end(), data.qpos);
  mj_kinematics(model_.get(), &data);
  mj_comPos(model_.get(), &data);
  mj_camlight(model_.get(), &data);
}

std::vector<double> DrawnModel::WithArmAt(std::span<const double> qpos,
                                          const JointVector& q) const {
  TWIN_CHECK(qpos.size() == qpos_size());
  std::vector<double> moved(qpos.begin(), qpos.end());
  const std::array<int, kJoints> joints = ArmJoints();
  for (std::size_t i = 0; i < kJoints; ++i) {
    moved[static_cast<std::size_t>(model_->jnt_qposadr[joints[i]])] = q[i];
  }
  return moved;
}

std::vector<double> DrawnModel::WithBodyAt(std::span<const double> qpos, const std::string& body,
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

int DrawnModel::BodyId(std::string_view name) const {
  const int id = mj_name2id(model_.get(), mjOBJ_BODY, std::string(name).c_str());
  if (id < 0) {
    throw InputError(fmt::format("render: the model has no body named \"{}\"; bodies it has: {}",
                                 name, NamesOf(*model_, mjOBJ_BODY, model_->nbody)));
  }
  return id;
}

int DrawnModel::CameraId(const std::string& name) const {
  const int id = mj_name2id(model_.get(), mjOBJ_CAMERA, name.c_str());
  if (id < 0) {
    throw InputError(fmt::format(
        "render: the model has no camera named \"{}\"; cameras it has: {}. Besides those there are "
        "orbit, gripper, and track:BODY (in a scenario, track: BODY)",
        name, NamesOf(*model_, mjOBJ_CAMERA, model_->ncam)));
  }
  return id;
}

std::array<int, kJoints> DrawnModel::ArmJoints() const {
  std::array<int, kJoints> joints{};
  for (std::size_t i = 0; i < kJoints; ++i) {
    const std::string name = fmt::format("panda_joint{}", i + 1);
    joints[i] = mj_name2id(model_.get(), mjOBJ_JOINT, name.c_str());
    if (joints[i] < 0) throw InputError(fmt::format("render: the model has no joint {}", name));
  }
  return joints;
}

}  // namespace twin::render
