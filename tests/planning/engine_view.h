#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <memory>
#include <set>
#include <string>
#include <utility>

#include <mujoco/mujoco.h>
#include <Eigen/Geometry>

#include "twin/core/joint_vector.h"
#include "twin/plant/mujoco_plant.h"

namespace twin::planning {

/// What the engine itself says about a configuration: a model compiled for itself, data of its own,
/// and mj_forward, as a simulation does. Shares nothing with the planner's world.
class EngineView {
 public:
  explicit EngineView(const plant::MujocoPlantOptions& options)
      : plant_(plant::MujocoPlant::Create(options)),
        model_(mj_copyModel(nullptr, &plant_->model()), mj_deleteModel) {
    model_->nconmax = 1000;  // room for all contacts of an arm that is in the middle of something
    data_.reset(mj_makeData(model_.get()));
    for (std::size_t i = 0; i < kJoints; ++i) {
      arm_[i] = Address("panda_joint" + std::to_string(i + 1));
    }
    fingers_ = {Address("panda_finger_joint1"), Address("panda_finger_joint2")};
  }

  [[nodiscard]] mjModel& model() { return *model_; }
  [[nodiscard]] const mjData& data() const { return *data_; }

  /// Puts arm and fingers somewhere and computes everything.
  void Set(const JointVector& q, double width) {
    for (std::size_t i = 0; i < kJoints; ++i) data_->qpos[arm_[i]] = q[i];
    for (const int finger : fingers_) data_->qpos[finger] = width / 2;
    mj_forward(model_.get(), data_.get());
  }

  /// Puts a free body of the scene somewhere. The next Set() counts it.
  void Put(const std::string& body, const Eigen::Quaterniond& turn, const Eigen::Vector3d& p) {
    const int id = mj_name2id(model_.get(), mjOBJ_BODY, body.c_str());
    mjtNum* pose = data_->qpos + model_->jnt_qposadr[model_->body_jntadr[id]];
    const std::array<double, 7> values{p.x(), p.y(), p.z(), turn.w(), turn.x(), turn.y(), turn.z()};
    std::copy(values.begin(), values.end(), pose);
  }

  /// Names of what touches a body.
  [[nodiscard]] std::set<std::string> ContactsOf(const std::string& body) const {
    std::set<std::string> names;
    for (int i = 0; i < data_->ncon; ++i) {
      const std::string a = NameOf(data_->contact[i].geom1);
      const std::string b = NameOf(data_->contact[i].geom2);
      if (a == body) names.insert(b);
      if (b == body) names.insert(a);
    }
    return names;
  }

  /// Pairs of names of what touches, at least one of them a moving link of the robot: bodies, and
  /// of the world its shapes.
  [[nodiscard]] std::set<std::pair<std::string, std::string>> RobotContacts() const {
    std::set<std::pair<std::string, std::string>> pairs;
    for (int i = 0; i < data_->ncon; ++i) {
      const mjContact& contact = data_->contact[i];
      if (!IsMovingLink(contact.geom1) && !IsMovingLink(contact.geom2)) continue;
      pairs.insert(std::minmax(NameOf(contact.geom1), NameOf(contact.geom2)));
    }
    return pairs;
  }

 private:
  [[nodiscard]] int Address(const std::string& joint) const {
    return model_->jnt_qposadr[mj_name2id(model_.get(), mjOBJ_JOINT, joint.c_str())];
  }
  [[nodiscard]] std::string NameOf(int geom) const {
    const int body = model_->geom_bodyid[geom];
    return body == 0 ? mj_id2name(model_.get(), mjOBJ_GEOM, geom)
                     : mj_id2name(model_.get(), mjOBJ_BODY, body);
  }
  [[nodiscard]] bool IsMovingLink(int geom) const {
    const int body = model_->geom_bodyid[geom];
    const std::string name = body == 0 ? "" : mj_id2name(model_.get(), mjOBJ_BODY, body);
    return name.starts_with("panda_") && name != "panda_link0";
  }

  std::array<int, kJoints> arm_{};
  std::array<int, 2> fingers_{};
  std::unique_ptr<plant::MujocoPlant> plant_;
  std::unique_ptr<mjModel, decltype(&mj_deleteModel)> model_;
  std::unique_ptr<mjData, decltype(&mj_deleteData)> data_{nullptr, mj_deleteData};
};

}  // namespace twin::planning
